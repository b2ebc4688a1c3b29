// SPDX-License-Identifier: Apache-2.0
// Tests of writing that cannot succeed: one sentence, and nothing left behind.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <fstream>

#include "image/test_pictures.h"
#include "image/writer.h"

namespace terray {
namespace {

ImageSpec specFor(const std::string& extension) {
    ImageSpec spec;
    spec.width = 400;
    spec.height = 700;
    spec.type = extension == ".exr" ? PixelType::Float : PixelType::Byte;
    return spec;
}

/// Random bytes or floats: they do not compress to nothing.
Result<void> writeNoise(const std::string& path, const ImageSpec& spec) {
    if (spec.type == PixelType::Float) {
        return writePicture(path, spec, seededPixels<float>(spec, 1), 50);
    }
    return writePicture(path, spec, seededPixels<uint8_t>(spec, 1), 50);
}

/// Files of this process cannot grow beyond some bytes: a full disk, as seen from here.
class FileSizeLimit {
public:
    explicit FileSizeLimit(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
        getrlimit(RLIMIT_FSIZE, &old_);
        const rlimit limit{bytes, old_.rlim_max};
        setrlimit(RLIMIT_FSIZE, &limit);
    }
    ~FileSizeLimit() {
        setrlimit(RLIMIT_FSIZE, &old_);
        std::signal(SIGXFSZ, handler_);
    }

private:
    rlimit old_{};
    void (*handler_)(int);
};

class FailingWriter : public ScratchFolder, public testing::WithParamInterface<const char*> {
protected:
    std::string target() const { return at("picture") + GetParam(); }
};

TEST_P(FailingWriter, FullDiskIsOneSentenceAndLeavesTheOldFile) {
    std::ofstream(target()) << "old";
    for (const rlim_t bytes : {rlim_t{0}, rlim_t{20000}}) {
        Result<void> done;
        {
            const FileSizeLimit limit(bytes);
            done = writeNoise(target(), specFor(GetParam()));
        }
        ASSERT_FALSE(done.ok());
        EXPECT_EQ(done.error().code, ErrorCode::Failed);
        EXPECT_THAT(done.error().message, testing::HasSubstr(target()));
        EXPECT_THAT(names(), testing::ElementsAre(std::string("picture") + GetParam()));
        std::string content;
        std::ifstream(target()) >> content;
        EXPECT_EQ(content, "old");
    }
}

TEST_P(FailingWriter, FullDeviceIsReported) {
    std::filesystem::create_symlink("/dev/full", target());
    const Result<void> done = writeNoise(target(), specFor(GetParam()));
    ASSERT_FALSE(done.ok());
    EXPECT_EQ(done.error().code, ErrorCode::Failed);
    EXPECT_TRUE(std::filesystem::is_character_file("/dev/full"));
    EXPECT_EQ(names().size(), 1u);
}

TEST_P(FailingWriter, AbandonedPicturesLeaveNothing) {
    const ImageSpec spec = specFor(GetParam());
    {
        Result<std::unique_ptr<ImageWriter>> writer = makeImageWriter(target(), spec);
        ASSERT_TRUE(writer.ok());
        EXPECT_EQ(names().size(), 1u);
        EXPECT_THAT(names()[0], testing::StartsWith(".picture"));
        const size_t half = 400 * 350 * 3;
        const Result<void> done =
            spec.type == PixelType::Byte
                ? (*writer)->writeRows(std::span<const uint8_t>(std::vector<uint8_t>(half)))
                : (*writer)->writeRows(std::span<const float>(std::vector<float>(half)));
        EXPECT_TRUE(done.ok());
    }
    EXPECT_TRUE(names().empty());
}

TEST_P(FailingWriter, PlacesThatCannotBeWrittenAreNamed) {
    const std::string missing = at("missing/picture") + GetParam();
    const Result<void> nowhere = writeNoise(missing, specFor(GetParam()));
    ASSERT_FALSE(nowhere.ok());
    EXPECT_EQ(nowhere.error().code, ErrorCode::Failed);
    EXPECT_THAT(nowhere.error().message, testing::HasSubstr(missing));
    EXPECT_THAT(nowhere.error().message, testing::HasSubstr("create the folder"));

    std::filesystem::create_directory(target());
    EXPECT_FALSE(writeNoise(target(), specFor(GetParam())).ok()) << "a folder is in the way";
    EXPECT_EQ(names().size(), 1u);
}

TEST_P(FailingWriter, LinksKeepPointingAtTheNewFile) {
    std::filesystem::create_directory(at("real"));
    const std::string real = at("real/kept") + GetParam();
    std::ofstream(real) << "old";
    std::filesystem::create_symlink(real, target());
    ASSERT_TRUE(writeNoise(target(), specFor(GetParam())).ok());
    EXPECT_TRUE(std::filesystem::is_symlink(target()));
    EXPECT_GT(std::filesystem::file_size(real), 1000u);
}

INSTANTIATE_TEST_SUITE_P(Formats, FailingWriter, testing::Values(".png", ".jpg", ".exr", ".tif"),
                         [](const auto& param) { return std::string(param.param + 1); });

class RefusedPictures : public ScratchFolder {
protected:
    std::string usageError(const std::string& name, const ImageSpec& spec) const {
        const Result<std::unique_ptr<ImageWriter>> writer = makeImageWriter(at(name), spec);
        EXPECT_FALSE(writer.ok());
        if (writer.ok()) return "";
        EXPECT_EQ(writer.error().code, ErrorCode::Usage);
        EXPECT_TRUE(names().empty());
        return writer.error().message;
    }
};

TEST_F(RefusedPictures, UnknownExtensionsNameTheKnownOnes) {
    ImageSpec spec;
    spec.width = spec.height = 1;
    EXPECT_THAT(usageError("a.bmp", spec), testing::HasSubstr(".png"));
    EXPECT_THAT(usageError("a", spec), testing::HasSubstr(".png"));
    EXPECT_THAT(usageError(".png", spec), testing::HasSubstr(".png"));
}

TEST_F(RefusedPictures, FormatsThatCannotHoldThePixelsNameOthers) {
    ImageSpec spec;
    spec.width = 70000;
    spec.height = 1;
    EXPECT_THAT(usageError("a.jpg", spec), testing::HasSubstr(".tif"));
    spec.width = 1;
    spec.channels = 4;
    EXPECT_THAT(usageError("a.jpg", spec), testing::HasSubstr(".png"));
    EXPECT_THAT(usageError("a.exr", spec), testing::HasSubstr(".png"));
    spec.type = PixelType::Float;
    EXPECT_THAT(usageError("a.png", spec), testing::HasSubstr(".exr"));
}

}  // namespace
}  // namespace terray
