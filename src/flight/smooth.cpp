// SPDX-License-Identifier: Apache-2.0
// Moving means and maxima.
#include "flight/smooth.h"

#include <algorithm>
#include <deque>

namespace terray {
namespace {

/// Value at any index, the ends turned over as `beyond` says.
double valueAt(const std::vector<double>& values, ptrdiff_t k, Beyond beyond) {
    const auto last = static_cast<ptrdiff_t>(values.size()) - 1;
    const ptrdiff_t inside = std::clamp(k < 0      ? -k
                                        : k > last ? 2 * last - k
                                                   : k,
                                        ptrdiff_t{0}, last);
    const double value = values[static_cast<size_t>(inside)];
    if (beyond == Beyond::Mirrored || (k >= 0 && k <= last)) return value;
    return 2 * (k < 0 ? values.front() : values.back()) - value;
}

std::vector<double> movingMean(const std::vector<double>& values, ptrdiff_t half, Beyond beyond) {
    const auto n = static_cast<ptrdiff_t>(values.size());
    const double width = static_cast<double>(2 * half + 1);
    std::vector<double> means(values.size());
    double sum = 0;
    for (ptrdiff_t k = -half; k <= half; ++k) sum += valueAt(values, k, beyond);
    for (ptrdiff_t k = 0; k < n; ++k) {
        means[static_cast<size_t>(k)] = sum / width;
        sum += valueAt(values, k + half + 1, beyond) - valueAt(values, k - half, beyond);
    }
    return means;
}

}  // namespace

std::vector<double> smoothed(const std::vector<double>& values, size_t reach, Beyond beyond) {
    if (values.size() < 2) return values;
    const auto half = static_cast<ptrdiff_t>(std::min(reach / 3, values.size() - 1));
    if (half == 0) return values;
    // Sums of differences from the first value stay exact enough for coordinates of any size.
    const double base = values.front();
    std::vector<double> result = values;
    for (double& value : result) value -= base;
    for (int pass = 0; pass < 3; ++pass) result = movingMean(result, half, beyond);
    for (double& value : result) value += base;
    return result;
}

std::vector<double> windowMaximum(const std::vector<double>& values, size_t reach) {
    const size_t n = values.size();
    std::vector<double> result(n);
    std::deque<size_t> falling;  // indices whose values fall
    for (size_t next = 0, k = 0; k < n; ++k) {
        for (; next < n && next <= k + reach; ++next) {
            while (!falling.empty() && values[falling.back()] <= values[next]) falling.pop_back();
            falling.push_back(next);
        }
        while (falling.front() + reach < k) falling.pop_front();
        result[k] = values[falling.front()];
    }
    return result;
}

}  // namespace terray
