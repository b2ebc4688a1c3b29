// SPDX-License-Identifier: Apache-2.0
// A photo in memory with its mips, cut into blocks, for tests; can be told to fail and to wait.
#pragma once

#include <algorithm>
#include <atomic>
#include <memory>
#include <thread>
#include <vector>

#include "tile/photo_blocks.h"
#include "tile/photo_mips.h"

namespace terray::test {

class ArrayPhoto final : public PhotoBlockSource {
public:
    struct Troubles {
        std::atomic<bool> isHeld{false};
        std::atomic<int> failures{0};  ///< that are still to come, of blocks of mip 0
    };
    /// Coloured noise, partly transparent, whole from pixel to pixel on every run.
    ArrayPhoto(int columns, int rows, std::shared_ptr<Troubles> troubles = nullptr)
        : grid_{columns, rows}, troubles_(std::move(troubles)) {
        std::vector<std::vector<uint8_t>> mips(1);
        std::vector<uint8_t>& finest = mips.front();
        for (int j = 0; j < rows; ++j) {
            for (int i = 0; i < columns; ++i) {
                const auto hash = static_cast<uint32_t>(i * 7919 + j * 104729) * 2654435761u;
                const bool isCovered = (i / 97 + j / 71) % 9 != 0;
                for (int c = 0; c < 3; ++c)
                    finest.push_back(static_cast<uint8_t>(isCovered ? hash >> (8 * c + 8) : 0u));
                finest.push_back(static_cast<uint8_t>(isCovered ? 255 : 0));
            }
        }
        for (int mip = 1; mip < grid_.mipCount(); ++mip) {
            const int width = static_cast<int>(grid_.columnsAt(mip));
            std::vector<uint8_t> coarse(static_cast<size_t>(width * grid_.rowsAt(mip) * 4));
            halvePhoto(mips.back().data(), static_cast<int>(grid_.columnsAt(mip - 1)),
                       static_cast<int>(grid_.rowsAt(mip - 1)), grid_.columnsAt(mip - 1) * 4,
                       coarse.data(), width * 4);
            mips.push_back(std::move(coarse));
        }
        mips_ = std::make_shared<const std::vector<std::vector<uint8_t>>>(std::move(mips));
    }
    PhotoGrid grid() const override { return grid_; }
    const Affine2& worldFromPixel() const override { return map_; }
    const std::string& description() const override { return description_; }
    Result<std::unique_ptr<PhotoBlockReader>> makeReader() const override {
        return std::unique_ptr<PhotoBlockReader>(new Reader(*this));
    }
    const std::vector<uint8_t>& pixels(int mip) const { return (*mips_)[static_cast<size_t>(mip)]; }

private:
    class Reader final : public PhotoBlockReader {
    public:
        explicit Reader(const ArrayPhoto& photo) : photo_(photo) {}
        Result<void> read(int mip, int x, int y, uint8_t* rgba) override {
            TERRAY_TRY(photo_.obey(mip, x, y));
            const int64_t columns = photo_.grid_.columnsAt(mip), rows = photo_.grid_.rowsAt(mip);
            const int64_t left = int64_t{x} * kPhotoBlockSide, top = int64_t{y} * kPhotoBlockSide;
            const int64_t width = std::min<int64_t>(kPhotoBlockSide, columns - left);
            std::fill_n(rgba, kPhotoBlockBytes, uint8_t{0});
            for (int64_t row = 0; row < std::min<int64_t>(kPhotoBlockSide, rows - top); ++row)
                std::copy_n(photo_.pixels(mip).data() + ((top + row) * columns + left) * 4,
                            width * 4, rgba + row * kPhotoBlockSide * 4);
            bytes_ += 1000;
            return {};
        }
        uint64_t bytesRead() const override { return bytes_; }

    private:
        const ArrayPhoto& photo_;
        uint64_t bytes_ = 0;
    };
    Result<void> obey(int mip, int x, int y) const {
        if (!troubles_) return {};
        while (troubles_->isHeld) std::this_thread::yield();
        if (mip == 0 && troubles_->failures > 0) {
            --troubles_->failures;
            return makeError(ErrorCode::Input, "block ({}, {}) is broken", x, y);
        }
        return {};
    }

    PhotoGrid grid_;
    std::shared_ptr<Troubles> troubles_;
    Affine2 map_{{0, 0}, {1, 0}, {0, -1}};
    std::string description_ = "noise";
    std::shared_ptr<const std::vector<std::vector<uint8_t>>> mips_;  ///< shared by copies
};

}  // namespace terray::test
