// SPDX-License-Identifier: Apache-2.0
// hashes.bin: XXH3 of every block of every file of a store, and of what lies between them.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "store/bytes.h"

namespace terray {

/// 64 bits of XXH3.
uint64_t hashOf(std::span<const std::byte> bytes);
std::string hashText(uint64_t hash);  ///< 16 hexadecimal digits

struct BlockRange {
    uint64_t offset = 0, size = 0;
    friend bool operator==(const BlockRange&, const BlockRange&) = default;
};
/// Of a file of that size.
inline bool isInside(const BlockRange& block, uint64_t size) {
    return block.size <= size && block.offset <= size - block.size;
}

/// Hashes of one file: its blocks (tiles of a TIFF, records of an edge file; a block without bytes
/// has size 0), and all the other bytes together.
struct FileHashes {
    std::string path;  ///< inside the store
    uint64_t size = 0, rest = 0;
    std::vector<BlockRange> blocks;
    std::vector<uint64_t> blockHashes;
    friend bool operator==(const FileHashes&, const FileHashes&) = default;
};

FileHashes hashFile(std::string path, std::span<const std::byte> bytes,
                    std::vector<BlockRange> blocks);

/// What differs between a file and its hashes.
struct FileDamage {
    bool size = false, rest = false;
    std::vector<size_t> blocks;
    bool isNone() const { return !size && !rest && blocks.empty(); }
};
FileDamage compareFile(const FileHashes& hashes, std::span<const std::byte> bytes);

/// One record of hashes.bin; the journal of a bake has the same ones.
void writeRecord(ByteWriter& out, const FileHashes& file);
/// False if the bytes are no record, or cut short.
bool readRecord(ByteReader& in, FileHashes& file);

Bytes encodeHashes(const std::vector<FileHashes>& files);
/// Error Input if the bytes are damaged.
Result<std::vector<FileHashes>> decodeHashes(const std::string& name,
                                             std::span<const std::byte> bytes);

}  // namespace terray
