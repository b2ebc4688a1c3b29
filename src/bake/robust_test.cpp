// SPDX-License-Identifier: Apache-2.0
// Bakes that fail, are repeated, meet each other, or find their store damaged.
#include <fcntl.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include <random>

#include "bake/test_folder.h"
#include "store/verify.h"

namespace terray {
namespace {

using test::ArraySource;
using test::bakeWell;
using test::contentOf;
using test::FailingCalls;
using test::filesOf;
using test::hills;
using test::planOf;
using test::TestFolder;

const ArraySource& smallSource() {
    static const ArraySource source(700, 600, PostFormat::Float32, hills(4, true));
    return source;
}

bool opens(const std::string& store) {
    return Store::open(store, uint64_t{1} << 30).ok() && checkStore(store)->damage.empty();
}

TEST(RobustBake, FullDiskAtEveryWriteThenGoesOn) {
    const TestFolder folder;
    BakePlan plan = planOf(smallSource(), 0.05);
    bakeWell(plan, folder / "good.terray");
    const auto good = filesOf(folder / "good.terray");
    FailingCalls calls;
    plan.calls = &calls;
    int failures = 0;
    for (int allowed = 1; allowed < 1000; ++allowed) {  // one more write gets through each time
        calls.writes = 0;
        calls.failFrom = allowed / 2 + 2;
        const auto outcome = bakeStore(plan, folder / "a.terray", false);
        if (outcome.ok()) break;
        ++failures;
        ASSERT_EQ(outcome.error().code, ErrorCode::Failed);
        ASSERT_NE(outcome.error().message.find("No space left"), std::string::npos)
            << outcome.error().message;
        ASSERT_FALSE(std::filesystem::exists(folder / "a.terray"));
    }
    EXPECT_GT(failures, 10);
    EXPECT_TRUE(filesOf(folder / "a.terray") == good);
    // Only a file whose journal entry could not be written is made again, at once.
    for (const auto& [name, times] : calls.renamed) {
        if (name.find("y") == std::string::npos || name.ends_with(".vrt")) continue;
        EXPECT_LE(times, 3) << name << " was made again";
    }
    EXPECT_EQ(calls.renamed.count("m0/y1_x0.tif"), 1u);
}

TEST(RobustBake, ShortAndInterruptedWritesAreCompleted) {
    const TestFolder folder;
    BakePlan plan = planOf(smallSource(), 0.05);
    bakeWell(plan, folder / "good.terray");
    FailingCalls calls;
    calls.shortWrites = true;
    calls.interruptAt = 7;
    plan.calls = &calls;
    bakeWell(plan, folder / "a.terray");
    EXPECT_TRUE(filesOf(folder / "a.terray") == filesOf(folder / "good.terray"));
}

TEST(RobustBake, PreviousStoreStaysUntilTheNewOneIsWhole) {
    const TestFolder folder;
    const std::string out = folder / "a.terray";
    bakeWell(planOf(smallSource(), 0.5), out);
    const auto before = filesOf(out);
    BakePlan plan = planOf(smallSource(), 0.05);
    FailingCalls calls;
    calls.failFrom = 9;
    plan.calls = &calls;
    EXPECT_FALSE(bakeStore(plan, out, false).ok());
    EXPECT_TRUE(filesOf(out) == before);
    EXPECT_TRUE(opens(out));
    calls.failFrom = 0;
    bakeWell(plan, out);
    EXPECT_TRUE(opens(out));
    EXPECT_FALSE(filesOf(out) == before);
    EXPECT_FALSE(std::filesystem::exists(out + ".baking.old"));
    EXPECT_FALSE(std::filesystem::exists(out + ".baking"));
    EXPECT_FALSE(std::filesystem::exists(out + ".lock"));
}

TEST(RobustBake, BadSourceRowIsOneErrorAndCanBeMended) {
    const TestFolder folder;
    ArraySource source(2100, 1100, PostFormat::Float32, hills(4, false));
    BakePlan plan = planOf(source, 0.05);
    plan.memoryBytes = 1 << 20;
    source.failAtRow(1090);
    const auto outcome = bakeStore(plan, folder / "a.terray", false);
    ASSERT_FALSE(outcome.ok());
    EXPECT_EQ(outcome.error().message, "row cannot be read");
    source.failAtRow(-1);
    const auto again = bakeStore(plan, folder / "a.terray", false);
    ASSERT_TRUE(again.ok());
    EXPECT_GE(again->foundFiles, 2u);
    bakeWell(plan, folder / "good.terray");
    EXPECT_TRUE(filesOf(folder / "a.terray") == filesOf(folder / "good.terray"));
}

TEST(RobustBake, UnfinishedBakeOfOtherOptionsIsLeftAlone) {
    const TestFolder folder;
    BakePlan plan = planOf(smallSource(), 0.05);
    FailingCalls calls;
    calls.failFrom = 9;
    plan.calls = &calls;
    ASSERT_FALSE(bakeStore(plan, folder / "a.terray", false).ok());
    const auto other = bakeStore(planOf(smallSource(), 0.5), folder / "a.terray", false);
    ASSERT_FALSE(other.ok());
    EXPECT_NE(other.error().message.find("unfinished bake"), std::string::npos);
}

TEST(RobustBake, SecondBakeIsRefusedAndADeadOwnersLockTakenOver) {
    const TestFolder folder;
    const std::string out = folder / "a.terray";
    const BakePlan plan = planOf(smallSource(), 0.05);
    int ready[2];
    ASSERT_EQ(::pipe(ready), 0);
    const pid_t child = ::fork();
    if (child == 0) {  // holds the lock until it is killed
        const int file = ::open((out + ".lock").c_str(), O_RDWR | O_CREAT, 0666);
        const bool held = ::flock(file, LOCK_EX | LOCK_NB) == 0;
        const char byte = held ? 'y' : 'n';
        if (::write(ready[1], &byte, 1) != 1) ::_exit(1);
        ::pause();
        ::_exit(0);
    }
    char byte = 0;
    ASSERT_EQ(::read(ready[0], &byte, 1), 1);
    ASSERT_EQ(byte, 'y');
    const auto refused = bakeStore(plan, out, false);
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, ErrorCode::Failed);
    EXPECT_NE(refused.error().message.find("being baked"), std::string::npos);
    EXPECT_TRUE(std::filesystem::exists(out + ".lock"));
    bakeWell(plan, out);
    EXPECT_TRUE(opens(out));
}

TEST(RobustBake, SameBakeAgainDoesNothing) {
    const TestFolder folder;
    BakePlan plan = planOf(smallSource(), 0.05);
    bakeWell(plan, folder / "a.terray");
    FailingCalls calls;
    plan.calls = &calls;
    for (const bool repair : {false, true}) {
        const auto again = bakeStore(plan, folder / "a.terray", repair);
        ASSERT_TRUE(again.ok());
        EXPECT_TRUE(again->wasDone);
    }
    EXPECT_EQ(calls.writes, 0);
}

void flip(const std::string& path, size_t at) {
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekg(static_cast<std::streamoff>(at));
    const char byte = static_cast<char>(file.get() ^ 0x10);
    file.seekp(static_cast<std::streamoff>(at));
    file.put(byte);
}

TEST(RobustBake, EveryFlippedByteIsNamedAndMended) {
    const TestFolder folder;
    const std::string out = folder / "a.terray";
    const BakePlan plan = planOf(smallSource(), 0.05);
    bakeWell(plan, out);
    const auto good = filesOf(out);
    std::minstd_rand random(11);
    for (const auto& [name, content] : good) {
        for (int k = 0; k < 25; ++k) {
            // the first and last bytes too, where headers and checks are
            const size_t at =
                k == 0   ? 0
                : k == 1 ? content.size() - 1
                         : std::uniform_int_distribution<size_t>(0, content.size() - 1)(random);
            flip(out + "/" + name, at);
            const auto check = checkStore(out);
            ASSERT_TRUE(check.ok());
            ASSERT_FALSE(check->damage.empty()) << name << " byte " << at;
            ASSERT_NE(check->damage[0].find(name), std::string::npos)
                << name << " byte " << at << ": " << check->damage[0];
            if (name.starts_with("height/m0/y") && at > 3000 && at + 1000 < content.size()) {
                EXPECT_NE(check->damage[0].find("tile ("), std::string::npos) << check->damage[0];
            }
            if (k > 1) {
                flip(out + "/" + name, at);
                continue;
            }
            bakeWell(plan, out, true);
            ASSERT_TRUE(filesOf(out) == good) << name;
        }
    }
    EXPECT_TRUE(checkStore(out)->damage.empty());
}

TEST(RobustBake, MissingAndCutFilesAreNamedAndOnlyTheyAreMadeAgain) {
    const TestFolder folder;
    const std::string out = folder / "a.terray";
    BakePlan plan = planOf(smallSource(), 0.05);
    bakeWell(plan, out);
    const auto good = filesOf(out);
    std::filesystem::remove(out + "/height/m0/y1_x0.tif");
    std::filesystem::resize_file(out + "/height/m1/y0_x0.tif", 500);
    EXPECT_GE(checkStore(out)->damage.size(), 2u);
    EXPECT_FALSE(opens(out));
    FailingCalls calls;
    plan.calls = &calls;
    bakeWell(plan, out, true);
    EXPECT_TRUE(filesOf(out) == good);
    EXPECT_EQ(calls.renamed["m0/y1_x0.tif"], 1);
    EXPECT_EQ(calls.renamed["m1/y0_x0.tif"], 1);
    EXPECT_EQ(calls.renamed["m0/y0_x0.tif"], 0);
    EXPECT_EQ(calls.renamed["edges/m0.bin"], 0);
}

TEST(RobustBake, DamagedTileIsAnErrorThatNamesIt) {
    const TestFolder folder;
    const std::string out = folder / "a.terray";
    bakeWell(planOf(smallSource(), 0.05), out);
    const auto size = std::filesystem::file_size(out + "/height/m0/y0_x0.tif");
    std::filesystem::resize_file(out + "/height/m0/y0_x0.tif", size / 2);
    const auto store = Store::open(out, uint64_t{1} << 30);
    ASSERT_TRUE(store.ok());
    auto reader = (*store)->makeReader();
    std::vector<float> posts(size_t{kTilePosts} * kTilePosts);
    const auto read = (*reader)->read({0, 1, 0}, posts.data(), kTilePosts);
    ASSERT_FALSE(read.ok());
    EXPECT_NE(read.error().message.find("tile (1, 0) of mip 0"), std::string::npos);
    EXPECT_NE(read.error().message.find("height/m0/y0_x0.tif"), std::string::npos);
    EXPECT_EQ(read.error().code, ErrorCode::Input);
}

}  // namespace
}  // namespace terray
