// SPDX-License-Identifier: Apache-2.0
// Log output over spdlog: plain lines on stderr, "note: " or "warning: " in front.
#include "base/log.h"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <mutex>
#include <set>

namespace terray::log {
namespace {

spdlog::logger& logger() {
    static const std::shared_ptr<spdlog::logger> instance = [] {
        auto sink = std::make_shared<spdlog::sinks::stderr_sink_mt>();
        sink->set_pattern("%v");
        auto made = std::make_shared<spdlog::logger>("terray", std::move(sink));
        made->set_level(spdlog::level::info);
        made->flush_on(spdlog::level::info);
        return made;
    }();
    return *instance;
}

std::mutex saidMutex;
int saidScopes = 0;
std::set<std::string> said;

bool isRepeated(const std::string& text) {
    const std::lock_guard lock(saidMutex);
    return saidScopes > 0 && !said.insert(text).second;
}

/// Names of files and bytes of damaged ones may hold anything.
std::string oneLine(std::string text) {
    for (char& c : text)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
    return text;
}

}  // namespace

void setVerbosity(Verbosity verbosity) {
    switch (verbosity) {
        case Verbosity::Quiet: logger().set_level(spdlog::level::warn); break;
        case Verbosity::Normal: logger().set_level(spdlog::level::info); break;
        case Verbosity::Verbose: logger().set_level(spdlog::level::debug); break;
    }
}

SayOnce::SayOnce() {
    const std::lock_guard lock(saidMutex);
    ++saidScopes;
}

SayOnce::~SayOnce() {
    const std::lock_guard lock(saidMutex);
    if (--saidScopes == 0) said.clear();
}

void writeNote(const std::string& text) {
    if (!isRepeated(text)) logger().info("note: " + oneLine(text));
}
void writeWarning(const std::string& text) {
    if (!isRepeated(text)) logger().warn("warning: " + oneLine(text));
}
void writeDetail(const std::string& text) { logger().debug(text); }

}  // namespace terray::log
