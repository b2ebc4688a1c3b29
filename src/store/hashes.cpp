// SPDX-License-Identifier: Apache-2.0
// Hashing of files block by block, and hashes.bin.
#include "store/hashes.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <numeric>

namespace terray {
namespace {

constexpr std::string_view kHashesMagic = "TERRAYHS";
constexpr uint32_t kVersion = 1;
constexpr uint32_t kMostFiles = 1u << 28;

/// Hash of all bytes outside of the blocks, in order.
class RestHash {
public:
    RestHash() { XXH3_64bits_reset(&state_); }
    void add(std::span<const std::byte> bytes) {
        XXH3_64bits_update(&state_, bytes.data(), bytes.size());
    }
    uint64_t value() const { return XXH3_64bits_digest(&state_); }

private:
    XXH3_state_t state_;
};

uint64_t hashRest(std::span<const std::byte> bytes, const std::vector<BlockRange>& blocks) {
    std::vector<size_t> order(blocks.size());
    std::iota(order.begin(), order.end(), size_t{0});
    std::sort(order.begin(), order.end(),
              [&](size_t a, size_t b) { return blocks[a].offset < blocks[b].offset; });
    RestHash rest;
    uint64_t at = 0;
    for (const size_t k : order) {
        const BlockRange& block = blocks[k];
        if (block.size == 0 || block.offset < at || block.offset > bytes.size()) continue;
        rest.add(bytes.subspan(at, block.offset - at));
        at = std::min<uint64_t>(block.offset + block.size, bytes.size());
    }
    rest.add(bytes.subspan(at));
    return rest.value();
}

uint64_t hashBlock(std::span<const std::byte> bytes, const BlockRange& block) {
    return hashOf(bytes.subspan(block.offset, block.size));
}

/// Paths lead into the store, whoever wrote them.
bool staysInside(const std::string& path) {
    return !path.empty() && path[0] != '/' && path.find("..") == std::string::npos &&
           path.find(':') == std::string::npos && path.find('\\') == std::string::npos;
}

}  // namespace

uint64_t hashOf(std::span<const std::byte> bytes) {
    return XXH3_64bits(bytes.data(), bytes.size());
}

std::string hashText(uint64_t hash) { return fmt::format("{:016x}", hash); }

FileHashes hashFile(std::string path, std::span<const std::byte> bytes,
                    std::vector<BlockRange> blocks) {
    FileHashes file{std::move(path), bytes.size(), hashRest(bytes, blocks), std::move(blocks), {}};
    for (const BlockRange& block : file.blocks) {
        file.blockHashes.push_back(hashBlock(bytes, block));
    }
    return file;
}

FileDamage compareFile(const FileHashes& hashes, std::span<const std::byte> bytes) {
    FileDamage damage;
    damage.size = bytes.size() != hashes.size;
    for (size_t k = 0; k < hashes.blocks.size(); ++k) {
        const BlockRange& block = hashes.blocks[k];
        if (!isInside(block, bytes.size()) || hashBlock(bytes, block) != hashes.blockHashes[k]) {
            damage.blocks.push_back(k);
        }
    }
    damage.rest = hashRest(bytes, hashes.blocks) != hashes.rest;
    return damage;
}

void writeRecord(ByteWriter& out, const FileHashes& file) {
    ByteWriter record;
    record.number(static_cast<uint16_t>(file.path.size()));
    record.text(file.path);
    record.number(file.size);
    record.number(file.rest);
    record.number(static_cast<uint32_t>(file.blocks.size()));
    for (size_t k = 0; k < file.blocks.size(); ++k) {
        record.number(file.blocks[k].offset);
        record.number(file.blocks[k].size);
        record.number(file.blockHashes[k]);
    }
    const uint64_t check = hashOf(record.view());
    record.number(check);
    const Bytes bytes = record.take();
    out.raw(bytes.data(), bytes.size());
}

bool readRecord(ByteReader& in, FileHashes& file) {
    file = {};
    file.path = in.text(in.number<uint16_t>());
    file.size = in.number<uint64_t>();
    file.rest = in.number<uint64_t>();
    const auto count = in.number<uint32_t>();
    if (!in.ok() || count > in.left() / (3 * sizeof(uint64_t))) return false;
    for (uint32_t k = 0; k < count; ++k) {
        const auto offset = in.number<uint64_t>(), size = in.number<uint64_t>();
        file.blocks.push_back({offset, size});
        file.blockHashes.push_back(in.number<uint64_t>());
    }
    const auto check = in.number<uint64_t>();
    if (!in.ok()) return false;
    ByteWriter again;
    writeRecord(again, file);
    const std::span<const std::byte> bytes = again.view();
    uint64_t expected = 0;
    std::memcpy(&expected, bytes.data() + bytes.size() - sizeof(expected), sizeof(expected));
    return check == expected;
}

Bytes encodeHashes(const std::vector<FileHashes>& files) {
    ByteWriter out;
    out.text(kHashesMagic);
    out.number(kVersion);
    out.number(static_cast<uint32_t>(files.size()));
    for (const FileHashes& file : files) writeRecord(out, file);
    out.number(hashOf(out.view()));
    return out.take();
}

Result<std::vector<FileHashes>> decodeHashes(const std::string& name,
                                             std::span<const std::byte> bytes) {
    const Error damaged = makeError(ErrorCode::Input, "'{}' is damaged", name);
    ByteReader in(bytes);
    if (in.text(kHashesMagic.size()) != kHashesMagic) return damaged;
    if (const auto version = in.number<uint32_t>(); in.ok() && version != kVersion) {
        return makeError(ErrorCode::Input, "'{}' has version {}; this Terray reads version {}",
                         name, version, kVersion);
    }
    const auto count = in.number<uint32_t>();
    if (!in.ok() || count > kMostFiles) return damaged;
    std::vector<FileHashes> files;
    for (uint32_t k = 0; k < count; ++k) {
        FileHashes file;
        if (!readRecord(in, file)) return damaged;
        if (!staysInside(file.path)) {
            return makeError(ErrorCode::Input, "'{}' names a file outside of the store: '{}'", name,
                             file.path);
        }
        files.push_back(std::move(file));
    }
    if (in.left() != sizeof(uint64_t)) return damaged;
    if (in.number<uint64_t>() != hashOf(bytes.first(bytes.size() - sizeof(uint64_t)))) {
        return damaged;
    }
    return files;
}

}  // namespace terray
