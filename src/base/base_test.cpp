// SPDX-License-Identifier: Apache-2.0
// Tests of results, the interrupt flag, words and memory figures.
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <optional>

#include "base/interrupt.h"
#include "base/log.h"
#include "base/progress.h"
#include "base/result.h"
#include "base/stopwatch.h"

namespace terray {
namespace {

Result<int> halfOf(int value) {
    if (value % 2 != 0) return makeError(ErrorCode::Input, "{} is odd; give an even number", value);
    return value / 2;
}

Result<void> checkHalf(int value) {
    TERRAY_TRY(halfOf(value));
    return {};
}

TEST(Result, CarriesValueOrSentence) {
    EXPECT_EQ(*halfOf(8), 4);
    const Result<int> bad = halfOf(3);
    ASSERT_FALSE(bad);
    EXPECT_EQ(bad.error().code, ErrorCode::Input);
    EXPECT_EQ(bad.error().message, "3 is odd; give an even number");
}

TEST(Result, TryPassesTheErrorOn) {
    EXPECT_TRUE(checkHalf(2).ok());
    EXPECT_EQ(checkHalf(5).error().message, "5 is odd; give an even number");
}

TEST(Interrupt, FlagIsSetBySignal) {
    setInterrupted(false);
    installInterruptHandler();
    std::raise(SIGINT);
    EXPECT_TRUE(isInterrupted());
    setInterrupted(false);
}

TEST(Progress, CountsWithoutATerminal) {
    Progress progress("test", 10);
    for (int i = 0; i < 10; ++i) progress.advance();
}

TEST(Stopwatch, MemoryFiguresArePlausible) {
    EXPECT_GT(peakResidentBytes(), 1u << 20);
    EXPECT_GT(physicalMemoryBytes(), peakResidentBytes());
}

TEST(Log, SaysThingsOnceWhileAskedTo) {
    const auto said = [](bool once) {
        testing::internal::CaptureStderr();
        std::optional<log::SayOnce> scope;
        if (once) scope.emplace();
        for (int k = 0; k < 3; ++k) {
            log::writeNote("the same");
            log::warning("number {}", k);
        }
        const std::string text = testing::internal::GetCapturedStderr();
        return std::count(text.begin(), text.end(), '\n');
    };
    EXPECT_EQ(said(false), 6);
    EXPECT_EQ(said(true), 4);
    EXPECT_EQ(said(true), 4);  // what was said before is forgotten
    EXPECT_EQ(said(false), 6);
}

}  // namespace
}  // namespace terray
