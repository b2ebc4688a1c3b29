// SPDX-License-Identifier: Apache-2.0
// Log output over spdlog: plain lines on stderr, "note: " or "warning: " in front.
#include "base/log.h"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

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

}  // namespace

void setVerbosity(Verbosity verbosity) {
    switch (verbosity) {
        case Verbosity::Quiet: logger().set_level(spdlog::level::warn); break;
        case Verbosity::Normal: logger().set_level(spdlog::level::info); break;
        case Verbosity::Verbose: logger().set_level(spdlog::level::debug); break;
    }
}

void writeNote(const std::string& text) { logger().info("note: " + text); }
void writeWarning(const std::string& text) { logger().warn("warning: " + text); }
void writeDetail(const std::string& text) { logger().debug(text); }

}  // namespace terray::log
