// SPDX-License-Identifier: Apache-2.0
// The device does what it is told, in order, within its budget, and the validation layer is silent.
#include "device/vulkan/device.h"

#include <filesystem>
#include <fstream>
#include <numeric>
#include <random>

#include "device/vulkan/commands.h"
#include "device/vulkan/test_device.h"
#include "device/vulkan/uploader.h"

namespace terray::vulkan {
namespace {

namespace fs = std::filesystem;

constexpr uint32_t kSumSpirv[] = {
#include "device/vulkan/test_sum.comp.inc"
};

struct SumConstants {
    uint64_t address;
    uint32_t count, pad = 0;
};

std::vector<uint32_t> randomNumbers(size_t count) {
    std::mt19937 random(7);
    std::vector<uint32_t> numbers(count);
    for (uint32_t& n : numbers) n = static_cast<uint32_t>(random());
    return numbers;
}

template <class T>
T taken(Result<T> result) {
    EXPECT_TRUE(result) << (result ? "" : result.error().message);
    return std::move(*result);
}

/// A file of this test alone.
class Folder {
public:
    Folder() {
        const auto* test = testing::UnitTest::GetInstance()->current_test_info();
        path_ = fs::temp_directory_path() /
                fmt::format("terray-{}-{}", test->test_suite_name(), test->name());
        fs::remove_all(path_);
    }
    ~Folder() { fs::remove_all(path_); }
    std::string path() const { return path_.string(); }

private:
    fs::path path_;
};

using VulkanDevice = VulkanTest;

TEST_F(VulkanDevice, UploadsAndReadsBackAnyBytes) {
    const auto numbers = randomNumbers(100'003);
    const auto bytes = std::as_bytes(std::span(numbers));
    const Buffer there = taken(device().makeBuffer(bytes.size(), MemoryKind::Device));
    const Buffer back = taken(device().makeBuffer(bytes.size(), MemoryKind::Readback));
    // Parts of 4 KiB: the ring goes round many times.
    const auto uploader = taken(Uploader::make(device(), 4096));
    ASSERT_TRUE(uploader->put(bytes, there, 0));
    ASSERT_TRUE(uploader->put(bytes.first(40), there, 400));
    ASSERT_TRUE(uploader->flush());
    EXPECT_EQ(uploader->uploadedBytes(), bytes.size() + 40);
    Commands& commands = *taken(device().begin());
    commands.barrier(Stage::Transfer, Stage::Transfer);
    commands.copy(there, 0, back, 0, bytes.size());
    commands.barrier(Stage::Transfer, Stage::Host);
    ASSERT_TRUE(device().wait(taken(device().submit())));
    auto expected = numbers;
    std::copy_n(numbers.begin(), 10, expected.begin() + 100);
    const auto found = back.mapped<uint32_t>();
    EXPECT_TRUE(std::equal(expected.begin(), expected.end(), found.begin(), found.end()));
}

TEST_F(VulkanDevice, ShadersSeeBuffersAddressesAndConstants) {
    const auto numbers = randomNumbers(1000);
    const std::array<uint32_t, 4> words{1, 10, 100, 1000};
    const Buffer input = taken(device().makeBuffer(4 * numbers.size(), MemoryKind::Device));
    const Buffer extra = taken(device().makeBuffer(sizeof(words), MemoryKind::Device));
    const Buffer sums = taken(device().makeBuffer(16 * 4, MemoryKind::Device));
    const Buffer back = taken(device().makeBuffer(16 * 4, MemoryKind::Readback));
    const auto uploader = taken(Uploader::make(device(), 65536));
    ASSERT_TRUE(uploader->put(std::as_bytes(std::span(numbers)), input, 0));
    ASSERT_TRUE(uploader->put(std::as_bytes(std::span(words)), extra, 0));
    ASSERT_TRUE(uploader->flush());
    const auto pipeline =
        taken(ComputePipeline::make(device(), kSumSpirv, {2, sizeof(SumConstants)}));
    const SumConstants constants{extra.address(), 1000};
    Commands& commands = *taken(device().begin());
    commands.stamp(0);
    ASSERT_TRUE(
        commands.dispatch(*pipeline, {&input, &sums}, std::as_bytes(std::span(&constants, 1)), 16));
    commands.stamp(1);
    commands.barrier(Stage::Compute, Stage::Transfer);
    commands.copy(sums, 0, back, 0, 64);
    commands.barrier(Stage::Transfer, Stage::Host);
    const Ticket ticket = taken(device().submit());
    ASSERT_TRUE(device().wait(ticket));
    for (size_t k = 0; k < 16; ++k) {
        const auto begin = numbers.begin() + static_cast<ptrdiff_t>(64 * k);
        const auto end = k < 15 ? begin + 64 : numbers.end();
        EXPECT_EQ(back.mapped<uint32_t>()[k], std::accumulate(begin, end, words[k % 4])) << k;
    }
    const auto ms = device().msBetween(ticket, 0, 1);
    if (device().physical().timestampBits > 0) {
        ASSERT_TRUE(ms);
        EXPECT_GT(*ms, 0.0);
        EXPECT_LT(*ms, 60'000.0);
    }
    EXPECT_FALSE(device().msBetween(ticket + 1, 0, 1));
}

TEST_F(VulkanDevice, TheRingOfCommandsGoesRoundInOrder) {
    const Buffer a = taken(device().makeBuffer(4, MemoryKind::Device));
    const Buffer back = taken(device().makeBuffer(4 * 40, MemoryKind::Readback));
    const Buffer source = taken(device().makeBuffer(4 * 40, MemoryKind::Upload));
    std::iota(source.mapped<uint32_t>().begin(), source.mapped<uint32_t>().end(), 5u);
    for (uint64_t k = 0; k < 40; ++k) {
        Commands& commands = *taken(device().begin());
        commands.barrier(Stage::Transfer, Stage::Transfer);
        commands.copy(source, 4 * k, a, 0, 4);
        commands.barrier(Stage::Transfer, Stage::Transfer);
        commands.copy(a, 0, back, 4 * k, 4);
        commands.barrier(Stage::Transfer, Stage::Host);
        ASSERT_TRUE(device().submit());
    }
    ASSERT_TRUE(device().waitIdle());
    for (uint32_t k = 0; k < 40; ++k) EXPECT_EQ(back.mapped<uint32_t>()[k], 5 + k);
}

TEST_F(VulkanDevice, MoreThanTheBudgetIsAnErrorThatNamesTheDevice) {
    const auto small = open({.budgetBytes = uint64_t{8} << 20});
    const Buffer fits = taken(small->makeBuffer(uint64_t{5} << 20, MemoryKind::Device));
    const auto more = small->makeBuffer(uint64_t{5} << 20, MemoryKind::Device);
    ASSERT_FALSE(more);
    EXPECT_EQ(more.error().code, ErrorCode::Resource);
    EXPECT_NE(more.error().message.find(small->name()), std::string::npos);
    EXPECT_NE(more.error().message.find("8 MiB"), std::string::npos) << more.error().message;
    const auto rest = small->makeBuffer(uint64_t{2} << 20, MemoryKind::Device);
    EXPECT_TRUE(rest);
}

TEST_F(VulkanDevice, MemoryIsGivenBack) {
    const auto small = open({.budgetBytes = uint64_t{8} << 20});
    for (int k = 0; k < 10; ++k)
        EXPECT_TRUE(small->makeBuffer(uint64_t{5} << 20, MemoryKind::Device));
    EXPECT_EQ(small->memory().reservedBytes(), 0u);
}

TEST_F(VulkanDevice, ALostDeviceSaysSo) {
    const auto lost = open({.submitsUntilLost = 1});
    ASSERT_TRUE(lost->begin());
    ASSERT_TRUE(lost->submit());
    EXPECT_FALSE(lost->isLost());
    ASSERT_TRUE(lost->begin());
    const auto submitted = lost->submit();
    ASSERT_FALSE(submitted);
    EXPECT_NE(submitted.error().message.find("VK_ERROR_DEVICE_LOST"), std::string::npos);
    EXPECT_TRUE(lost->isLost());
}

TEST_F(VulkanDevice, PipelinesAreKeptForTheNextRun) {
    const Folder folder;
    std::string path;
    for (const bool known : {false, true}) {
        const auto one = open({.cacheFolder = folder.path()});
        EXPECT_EQ(one->pipelines().wasRead(), known);
        path = one->pipelines().path();
        EXPECT_TRUE(ComputePipeline::make(*one, kSumSpirv, {2, sizeof(SumConstants)}));
    }
    EXPECT_GT(fs::file_size(path), 24u);
}

TEST_F(VulkanDevice, ADamagedFileOfPipelinesCountsAsNone) {
    const Folder folder;
    std::string path;
    {
        const auto one = open({.cacheFolder = folder.path()});
        path = one->pipelines().path();
        EXPECT_TRUE(ComputePipeline::make(*one, kSumSpirv, {2, sizeof(SumConstants)}));
    }
    const auto size = static_cast<int64_t>(fs::file_size(path));
    std::string whole(static_cast<size_t>(size), '\0');
    std::ifstream(path, std::ios::binary).read(whole.data(), size);
    for (const size_t at : {size_t{0}, size_t{9}, size_t{30}, whole.size() - 1}) {
        std::string damaged = whole;
        damaged[at] = static_cast<char>(damaged[at] ^ 4);
        std::ofstream(path, std::ios::binary) << damaged;
        EXPECT_FALSE(open({.cacheFolder = folder.path()})->pipelines().wasRead()) << at;
    }
    std::ofstream(path, std::ios::binary) << whole.substr(0, whole.size() / 2);
    EXPECT_FALSE(open({.cacheFolder = folder.path()})->pipelines().wasRead());
}

TEST_F(VulkanDevice, AFolderThatCannotBeWrittenIsNoHarm) {
    EXPECT_TRUE(open({.cacheFolder = "/proc/no/such/folder"}));
}

TEST_F(VulkanDevice, IsChosenByNumberAndByName) {
    EXPECT_EQ(open({.which = "0"})->name(), device().name());
    EXPECT_EQ(open({.which = device().name().substr(0, 4)})->name(), device().name());
    for (const char* which : {"99", "Voodoo"}) {
        const auto none = Device::open({.which = which});
        ASSERT_FALSE(none);
        EXPECT_EQ(none.error().code, ErrorCode::Resource);
        EXPECT_NE(none.error().message.find(which), std::string::npos);
    }
}

}  // namespace
}  // namespace terray::vulkan
