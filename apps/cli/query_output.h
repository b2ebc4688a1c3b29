// SPDX-License-Identifier: Apache-2.0
// Answers of `terray query` as CSV or JSON.
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace terray::cli {

/// A number (NaN: nothing), or yes/no.
using Value = std::variant<double, bool>;

/// Rows of answers under column names.
struct Answers {
    std::vector<std::string> columns;
    std::vector<std::vector<Value>> rows;
};

/// Header and one line a row; nothing is an empty field, yes/no is 1/0.
std::string answersCsv(const Answers& answers);
/// An array with one object a row; nothing is null.
std::string answersJson(const Answers& answers);

}  // namespace terray::cli
