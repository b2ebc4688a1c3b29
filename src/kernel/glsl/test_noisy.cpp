// SPDX-License-Identifier: Apache-2.0
// The shader text with arithmetic as bad as Vulkan allows: every operation goes to either
// neighbouring float, quotients are 2.5 ulp off and roots 4, at random. What the text then calls
// certain must still be.
#include <bit>
#include <cmath>
#include <cstdint>

#include "kernel/glsl/test_program.h"

namespace terray::noisy {
namespace {

using uint = uint32_t;  // NOLINT(readability-identifier-naming): the name in GLSL

uint64_t randomBits() {
    thread_local uint64_t state = 88172645463325252u;
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return state;
}

class Float {
public:
    Float() = default;
    Float(float value) : value_(value) {}
    explicit Float(int value) : value_(static_cast<float>(value)) {}
    explicit Float(uint value) : value_(static_cast<float>(value)) {}
    explicit operator int() const { return static_cast<int>(value_); }
    float value() const { return value_; }

    friend Float operator+(Float a, Float b) { return either(a.wide() + b.wide()); }
    friend Float operator-(Float a, Float b) { return either(a.wide() - b.wide()); }
    friend Float operator*(Float a, Float b) { return either(a.wide() * b.wide()); }
    friend Float operator/(Float a, Float b) { return away(either(a.wide() / b.wide()), 2); }
    Float operator-() const { return -value_; }
    Float& operator+=(Float b) { return *this = *this + b; }
    Float& operator-=(Float b) { return *this = *this - b; }
    friend bool operator<(Float a, Float b) { return a.value_ < b.value_; }
    friend bool operator>(Float a, Float b) { return a.value_ > b.value_; }
    friend bool operator<=(Float a, Float b) { return a.value_ <= b.value_; }
    friend bool operator>=(Float a, Float b) { return a.value_ >= b.value_; }
    friend bool operator!=(Float a, Float b) { return a.value_ != b.value_; }

    /// The float below or above a number, unless it is one.
    static Float either(double exact) {
        const auto near = static_cast<float>(exact);
        const auto back = static_cast<double>(near);
        if (back == exact || !std::isfinite(near) || (randomBits() & 1) != 0) return near;
        return std::nextafter(near, back < exact ? HUGE_VALF : -HUGE_VALF);
    }
    /// Up to so many floats aside.
    static Float away(Float from, int most) {
        const float to = (randomBits() & 1) != 0 ? HUGE_VALF : -HUGE_VALF;
        const auto steps = static_cast<int>(randomBits() % static_cast<uint64_t>(most + 1));
        for (int k = 0; k < steps && std::isfinite(from.value_); ++k)
            from = std::nextafter(from.value_, to);
        return from;
    }

private:
    double wide() const { return static_cast<double>(value_); }
    float value_;
};

int min(int a, int b) { return a < b ? a : b; }
int max(int a, int b) { return a > b ? a : b; }
uint max(uint a, uint b) { return a > b ? a : b; }
Float min(Float a, Float b) { return a < b ? a : b; }
Float max(Float a, Float b) { return a > b ? a : b; }
int clamp(int x, int low, int high) { return min(max(x, low), high); }
Float clamp(Float x, Float low, Float high) { return min(max(x, low), high); }
Float abs(Float x) { return std::fabs(x.value()); }
Float floor(Float x) { return std::floor(x.value()); }
Float sqrt(Float x) { return max(Float::away(std::sqrt(x.value()), 4), Float(0.0f)); }
Float uintBitsToFloat(uint bits) { return std::bit_cast<float>(bits); }
Float intBitsToFloat(int bits) { return std::bit_cast<float>(bits); }

#define float Float
#include "kernel/glsl/layout.glsl"
#undef float

}  // namespace
}  // namespace terray::noisy

#define float Float
#define SHADER_SPACE noisy
#define SHADER_TRACE shaderTraceNoisy
#include "kernel/glsl/test_program.h.inl"
