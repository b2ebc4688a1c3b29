// SPDX-License-Identifier: Apache-2.0
// GDAL's set-up for the process: drivers, a bounded block cache, and no word of its own on stderr.
#include "dataset/gdal_handle.h"

#include <algorithm>
#include <mutex>

#include "base/log.h"

namespace terray {
namespace {

constexpr uint64_t kDefaultCacheBytes = 16u << 20;

/// What a user has not set for GDAL: a server that says nothing for so many seconds, or next to
/// nothing, has failed.
constexpr const char* kNetworkDefaults[][2] = {
    {"GDAL_HTTP_CONNECTTIMEOUT", "10"},   {"GDAL_HTTP_LOW_SPEED_TIME", "10"},
    {"GDAL_HTTP_LOW_SPEED_LIMIT", "100"}, {"GDAL_HTTP_MAX_RETRY", "2"},
    {"GDAL_HTTP_RETRY_DELAY", "1"},
};

std::mutex messageMutex;
std::string lastMessage;  // of any thread: GDAL decodes blocks on threads of its own

std::string oneLine(std::string text) {
    std::replace(text.begin(), text.end(), '\n', ' ');
    while (!text.empty() && (text.back() == ' ' || text.back() == '.')) text.pop_back();
    return text;
}

void CPL_STDCALL keepMessage(CPLErr severity, CPLErrorNum, const char* text) {
    if (severity == CE_Debug || severity == CE_None) return;
    const std::string line = oneLine(text);
    if (severity == CE_Warning) log::writeDetail("GDAL: " + line);
    const std::lock_guard lock(messageMutex);
    lastMessage = line;
}

void registerOnce() {
    static std::once_flag once;
    std::call_once(once, [] {
        CPLSetErrorHandler(keepMessage);
        GDALAllRegister();
        for (const auto& [option, value] : kNetworkDefaults) {
            if (CPLGetConfigOption(option, nullptr) == nullptr) CPLSetConfigOption(option, value);
        }
        GDALSetCacheMax64(static_cast<GIntBig>(kDefaultCacheBytes));
    });
}

}  // namespace

void ensureGdal() { registerOnce(); }

void initialiseGdal(uint64_t cacheBytes) {
    registerOnce();
    GDALSetCacheMax64(static_cast<GIntBig>(cacheBytes));
}

void clearGdalMessage() {
    CPLErrorReset();
    const std::lock_guard lock(messageMutex);
    lastMessage.clear();
}

std::string gdalMessage() {
    const std::string own = oneLine(CPLGetLastErrorMsg());
    if (!own.empty()) return own;
    const std::lock_guard lock(messageMutex);
    return lastMessage;
}

}  // namespace terray
