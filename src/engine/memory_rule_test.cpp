// SPDX-License-Identifier: Apache-2.0
// The memory budget: defaults, what is refused, and advice that works.
#include "engine/memory_rule.h"

#include <gtest/gtest.h>

#include <random>
#include <regex>

namespace terray {
namespace {

constexpr uint64_t kMiB = uint64_t{1} << 20;
constexpr uint64_t kGiB = uint64_t{1} << 30;

TEST(MemoryRule, DefaultIsTheSmallerOf2GiBAndHalfOfTheRam) {
    EXPECT_EQ(planMemory("a", 0, 0, 64 * kGiB)->budget, 2 * kGiB);
    EXPECT_EQ(planMemory("a", 0, 0, 1 * kGiB)->budget, kGiB / 2);
    EXPECT_EQ(planMemory("a", 0, 100 * kMiB, 64 * kGiB)->budget, 100 * kMiB);
}

TEST(MemoryRule, PartsStayWithinTheBudget) {
    std::mt19937_64 random(7);
    for (int k = 0; k < 2000; ++k) {
        const uint64_t asked = 16 * kMiB + random() % (8 * kGiB);
        const uint64_t required = random() % asked;
        const auto plan = planMemory("a", required, asked, 64 * kGiB);
        if (!plan) continue;
        EXPECT_LE(required + plan->gdalCache + plan->frame + plan->photo, asked);
    }
}

TEST(MemoryRule, TooLargeIsRefusedWithABudgetThatIsEnough) {
    std::mt19937_64 random(8);
    for (int k = 0; k < 500; ++k) {
        const uint64_t required = 17 * kMiB + random() % (30 * kGiB);
        const auto plan = planMemory("big.tif", required, 16 * kMiB, 64 * kGiB);
        ASSERT_FALSE(plan);
        EXPECT_EQ(plan.error().code, ErrorCode::Input);
        EXPECT_NE(plan.error().message.find("big.tif"), std::string::npos);
        std::smatch match;
        const std::string& message = plan.error().message;
        ASSERT_TRUE(std::regex_search(message, match, std::regex("--memory ([0-9]+)MiB")))
            << message;
        const uint64_t advised = std::stoull(match[1]) * kMiB;
        EXPECT_TRUE(planMemory("big.tif", required, advised, 64 * kGiB).ok()) << message;
    }
}

TEST(MemoryRule, MoreThanTheMachineHasIsNotAdvised) {
    const auto plan = planMemory("big.tif", 100 * kGiB, 0, 8 * kGiB);
    ASSERT_FALSE(plan);
    EXPECT_EQ(plan.error().message.find("use --memory"), std::string::npos);
    EXPECT_NE(plan.error().message.find("gdal_translate"), std::string::npos);
}

}  // namespace
}  // namespace terray
