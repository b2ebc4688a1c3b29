// SPDX-License-Identifier: Apache-2.0
// Result<T>: a value, or an Error with one clear sentence. Nothing in Terray's API throws.
#pragma once

#include <cassert>
#include <string>
#include <utility>
#include <variant>

namespace terray {

/// Why something could not be done. The values are the exit codes of the command line.
enum class ErrorCode {
    Failed = 1,         ///< the work itself failed: write failed, disk full
    Usage = 2,          ///< an option or argument is wrong
    Input = 3,          ///< an input is unreadable or refused
    Resource = 4,       ///< a device or another resource is missing
    Interrupted = 130,  ///< the user stopped it (Ctrl-C)
};

/// One sentence for people: names the file or option, what is wrong, and what to do.
struct Error {
    ErrorCode code = ErrorCode::Failed;
    std::string message;
};

/// Either a T or an Error. `if (!r) return r.error();` is the way to pass an error on.
template <class T>
class [[nodiscard]] Result {
public:
    Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
    Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

    bool ok() const { return state_.index() == 0; }
    explicit operator bool() const { return ok(); }

    T& value() & {
        assert(ok());
        return *std::get_if<0>(&state_);
    }
    const T& value() const& {
        assert(ok());
        return *std::get_if<0>(&state_);
    }
    T&& value() && {
        assert(ok());
        return std::move(*std::get_if<0>(&state_));
    }
    T& operator*() & { return value(); }
    const T& operator*() const& { return value(); }
    T* operator->() { return &value(); }
    const T* operator->() const { return &value(); }
    const Error& error() const {
        assert(!ok());
        return *std::get_if<1>(&state_);
    }

private:
    std::variant<T, Error> state_;
};

template <>
class [[nodiscard]] Result<void> {
public:
    Result() = default;
    Result(Error error) : error_(std::move(error)), ok_(false) {}

    bool ok() const { return ok_; }
    explicit operator bool() const { return ok_; }
    const Error& error() const {
        assert(!ok_);
        return error_;
    }

private:
    Error error_;
    bool ok_ = true;
};

}  // namespace terray
