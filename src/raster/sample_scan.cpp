// SPDX-License-Identifier: Apache-2.0
// The pass over all samples: every thread takes one run of rows, with a reader of its own.
#include "raster/sample_scan.h"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

#include "base/interrupt.h"
#include "base/progress.h"
#include "raster/sample_reader.h"

namespace terray {
namespace {

constexpr int64_t kScanSamples = int64_t{1} << 19;

template <class Raw>
void addToRange(const std::vector<Raw>& raw, SampleRange& range) {
    Raw lowest = std::numeric_limits<Raw>::infinity(), highest = -lowest;
    int64_t holes = 0;
    for (const Raw value : raw) {
        holes += value != value;
        lowest = value < lowest ? value : lowest;
        highest = value > highest ? value : highest;
    }
    range.holes += holes;
    if (lowest > highest) return;
    range.rawMin = range.hasRange ? std::min(range.rawMin, static_cast<double>(lowest)) : lowest;
    range.rawMax = range.hasRange ? std::max(range.rawMax, static_cast<double>(highest)) : highest;
    range.hasRange = true;
}

template <class Raw>
Result<SampleRange> scanRows(const RasterHeader& header, int64_t firstRow, int64_t endRow,
                             Progress& progress) {
    Result<std::unique_ptr<SampleReader>> reader = SampleReader::open(header);
    if (!reader) return reader.error();
    SampleRange range;
    std::vector<Raw> raw;
    const SampleWindow all{0, firstRow, header.columns, endRow - firstRow};
    const auto addPart = [&](const SampleWindow& part) -> Result<void> {
        if (isInterrupted()) return makeError(ErrorCode::Interrupted, "interrupted");
        raw.resize(part.size());
        TERRAY_TRY((*reader)->readRaw(part, std::span<Raw>(raw)));
        addToRange(raw, range);
        progress.advance(static_cast<double>(part.samples()));
        return {};
    };
    TERRAY_TRY(forEachPart(all, header, kScanSamples, addPart));
    return range;
}

}  // namespace

Result<SampleRange> scanSamples(const RasterHeader& header) {
    const int64_t blockRows = std::max(header.blockRows, 1);
    const int64_t blocks = (header.rows + blockRows - 1) / blockRows;
    const int64_t threads = oneapi::tbb::this_task_arena::max_concurrency();
    const int64_t useful = header.columns * header.rows / kScanSamples + 1;
    const int64_t runs = std::min({blocks, threads, useful});
    std::vector<std::optional<Result<SampleRange>>> results(static_cast<size_t>(runs));
    Progress progress(fmt::format("scanning {}", header.name),
                      static_cast<double>(header.columns * header.rows));
    oneapi::tbb::parallel_for(int64_t{0}, runs, [&](int64_t run) {
        const int64_t first = blocks * run / runs * blockRows;
        const int64_t end = std::min(blocks * (run + 1) / runs * blockRows, header.rows);
        results[static_cast<size_t>(run)] = header.rules.wide
                                                ? scanRows<double>(header, first, end, progress)
                                                : scanRows<float>(header, first, end, progress);
    });
    SampleRange all;
    for (const std::optional<Result<SampleRange>>& result : results) {
        if (!result->ok()) return result->error();
        const SampleRange& part = **result;
        all.holes += part.holes;
        if (!part.hasRange) continue;
        all.rawMin = all.hasRange ? std::min(all.rawMin, part.rawMin) : part.rawMin;
        all.rawMax = all.hasRange ? std::max(all.rawMax, part.rawMax) : part.rawMax;
        all.hasRange = true;
    }
    return all;
}

}  // namespace terray
