// SPDX-License-Identifier: Apache-2.0
// Reading by pieces and comparing with hashes.
#include "store/checked_files.h"

#include <cpl_vsi.h>
#include <sys/mman.h>

#include <algorithm>
#include <cstring>

#include "base/assert.h"
#include "dataset/remote.h"
#include "store/format.h"
#include "store/gdal_scope.h"

namespace terray {
namespace {

constexpr uint64_t kMostHashBytes = uint64_t{1} << 34;
constexpr uint64_t kMostFileBytes = uint64_t{1} << 34;
constexpr size_t kMostHeaders = 8192;
constexpr size_t kRecordStart = 16;  ///< magic, version, number of files

Error damaged() { return makeError(ErrorCode::Input, "'{}' is damaged", kHashesName); }

/// What lies between the blocks of a file, in order.
std::vector<BlockRange> gapsOf(const FileHashes& file) {
    std::vector<BlockRange> blocks = file.blocks, gaps;
    std::sort(blocks.begin(), blocks.end(),
              [](const BlockRange& a, const BlockRange& b) { return a.offset < b.offset; });
    uint64_t at = 0;
    for (const BlockRange& block : blocks) {
        if (block.size == 0) continue;
        if (block.offset > at) gaps.push_back({at, block.offset - at});
        at = std::max(at, block.offset + block.size);
    }
    if (at < file.size) gaps.push_back({at, file.size - at});
    return gaps;
}

}  // namespace

Result<std::unique_ptr<StoreFiles>> StoreFiles::open(std::string folder, FilePieces& pieces,
                                                     const std::string& hash) {
    const std::string path = fileIn(folder, kHashesName);
    auto bytes = pieces.readAll(path, kMostHashBytes);
    if (!bytes) return bytes.error();
    if (hashText(hashOf(*bytes)) != hash) {
        pieces.forget(path);
        return makeError(ErrorCode::Input,
                         "'{}' is not the one that {} belongs to: it is damaged or has changed "
                         "meanwhile; run again, or mend the store with `terray bake --resume`",
                         shownName(path), kManifestName);
    }
    std::unique_ptr<StoreFiles> files(new StoreFiles);
    files->folder_ = std::move(folder);
    files->bytes_ = std::move(*bytes);
    const std::span<const std::byte> all = files->bytes_;
    if (all.size() < kRecordStart) return damaged();
    ByteReader counter(all.subspan(kRecordStart - sizeof(uint32_t)));
    const auto count = counter.number<uint32_t>();
    ByteReader in(all.subspan(kRecordStart));
    for (uint32_t k = 0; k < count; ++k) {
        files->places_.push_back(all.size() - in.left());
        in.text(in.number<uint16_t>());
        in.number<uint64_t>();
        in.number<uint64_t>();
        const auto blocks = in.number<uint32_t>();
        if (!in.ok() || blocks > in.left() / (3 * sizeof(uint64_t))) return damaged();
        in.skip(blocks * 3 * sizeof(uint64_t) + sizeof(uint64_t));
        if (!in.ok()) return damaged();
    }
    std::sort(files->places_.begin(), files->places_.end(),
              [&](size_t a, size_t b) { return files->textAt(a) < files->textAt(b); });
    return files;
}

std::string StoreFiles::textAt(size_t record) const {
    ByteReader in(std::span<const std::byte>(bytes_).subspan(record));
    return in.text(in.number<uint16_t>());
}

Result<FileHashes> StoreFiles::hashesOf(const std::string& name) const {
    const auto place =
        std::lower_bound(places_.begin(), places_.end(), name,
                         [&](uint64_t at, const std::string& text) { return textAt(at) < text; });
    FileHashes file;
    if (place == places_.end() || textAt(*place) != name) {
        return makeError(ErrorCode::Input, "the store has no '{}'", name);
    }
    ByteReader in(std::span<const std::byte>(bytes_).subspan(*place));
    if (!readRecord(in, file)) return damaged();
    for (const BlockRange& block : file.blocks) {
        if (!isInside(block, file.size)) return damaged();
    }
    return file;
}

FileImage::~FileImage() {
    if (data_ == nullptr) return;
    VSIUnlink(path_.c_str());
    munmap(data_, hashes_.size);
}

Error CheckedReader::differs(const std::string& name) {
    pieces_.forget(fileIn(files_.folder(), name));
    return makeError(ErrorCode::Input, "'{}' does not have the bytes that were baked", name);
}

Result<void> CheckedReader::readPiece(const std::string& name, BlockRange range,
                                      std::span<std::byte> out) {
    const Result<void> done = pieces_.read(fileIn(files_.folder(), name), range.offset, out);
    if (done) bytesRead_ += out.size();
    if (done || done.error().code == ErrorCode::Interrupted) return done;
    return makeError(done.error().code, "'{}': {}", name, done.error().message);
}

Result<std::shared_ptr<const Bytes>> CheckedReader::headerOf(const FileHashes& file) {
    {
        const std::lock_guard lock(files_.mutex_);
        const auto found = files_.headers_.find(file.path);
        if (found != files_.headers_.end()) return found->second;
    }
    auto header = std::make_shared<Bytes>();
    for (const BlockRange& gap : gapsOf(file)) {
        const size_t at = header->size();
        header->resize(at + gap.size);
        TERRAY_TRY(readPiece(file.path, gap, std::span(*header).subspan(at)));
    }
    if (hashOf(*header) != file.rest) return differs(file.path);
    const std::lock_guard lock(files_.mutex_);
    if (files_.headers_.size() >= kMostHeaders) files_.headers_.clear();
    files_.headers_[file.path] = header;
    return std::shared_ptr<const Bytes>(header);
}

Result<std::unique_ptr<FileImage>> CheckedReader::open(const std::string& name) {
    auto hashes = files_.hashesOf(name);
    if (!hashes) return hashes.error();
    auto header = headerOf(*hashes);
    if (!header) return header.error();
    std::unique_ptr<FileImage> image(new FileImage);
    image->name_ = name;
    image->hashes_ = std::move(*hashes);
    image->isHere_.assign(image->hashes_.blocks.size(), false);
    void* data = mmap(nullptr, image->hashes_.size, PROT_READ | PROT_WRITE,
                      MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (data == MAP_FAILED) {
        return makeError(ErrorCode::Resource, "there is no memory for '{}'", name);
    }
    image->data_ = static_cast<std::byte*>(data);
    const std::byte* from = (*header)->data();
    for (const BlockRange& gap : gapsOf(image->hashes_)) {
        std::copy_n(from, gap.size, image->data_ + gap.offset);
        from += gap.size;
    }
    image->path_ = memoryFileName();
    VSIFCloseL(VSIFileFromMemBuffer(image->path_.c_str(), reinterpret_cast<GByte*>(data),
                                    image->hashes_.size, FALSE));
    return image;
}

Result<void> CheckedReader::need(FileImage& image, size_t block) {
    if (block >= image.isHere_.size()) return differs(image.name_);
    if (image.isHere_[block]) return {};
    const BlockRange range = image.hashes_.blocks[block];
    TERRAY_TRY(read(image.hashes_, block, {image.data_ + range.offset, range.size}));
    image.isHere_[block] = true;
    return {};
}

Result<void> CheckedReader::read(const FileHashes& file, size_t block, std::span<std::byte> out) {
    TERRAY_ASSERT(block < file.blocks.size() && out.size() == file.blocks[block].size);
    TERRAY_TRY(readPiece(file.path, file.blocks[block], out));
    if (hashOf(out) != file.blockHashes[block]) return differs(file.path);
    return {};
}

Result<Bytes> CheckedReader::readAll(const std::string& name) {
    const auto hashes = files_.hashesOf(name);
    if (!hashes) return hashes.error();
    const std::string path = fileIn(files_.folder(), name);
    auto bytes = pieces_.readAll(path, std::min(hashes->size, kMostFileBytes));
    if (!bytes) return bytes.error();
    if (!compareFile(*hashes, *bytes).isNone()) {
        pieces_.forget(path);
        return makeError(ErrorCode::Input,
                         "'{}' does not have the bytes that were baked; run again, or look at the "
                         "store with `terray verify`",
                         shownName(path));
    }
    return bytes;
}

}  // namespace terray
