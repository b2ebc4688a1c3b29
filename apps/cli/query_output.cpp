// SPDX-License-Identifier: Apache-2.0
// Writing answers. Numbers are the shortest text that reads back as the same double.
#include "query_output.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace terray::cli {

std::string answersCsv(const Answers& answers) {
    std::string text = fmt::format("{}\n", fmt::join(answers.columns, ","));
    for (const auto& row : answers.rows) {
        for (size_t k = 0; k < row.size(); ++k) {
            if (k > 0) text += ',';
            if (const double* number = std::get_if<double>(&row[k])) {
                if (!std::isnan(*number)) text += fmt::format("{}", *number);
            } else {
                text += std::get<bool>(row[k]) ? '1' : '0';
            }
        }
        text += '\n';
    }
    return text;
}

std::string answersJson(const Answers& answers) {
    auto list = nlohmann::ordered_json::array();
    for (const auto& row : answers.rows) {
        nlohmann::ordered_json object;
        for (size_t k = 0; k < row.size(); ++k) {
            auto& field = object[answers.columns[k]];
            if (const double* number = std::get_if<double>(&row[k])) {
                if (!std::isnan(*number)) field = *number;
            } else {
                field = std::get<bool>(row[k]);
            }
        }
        list.push_back(std::move(object));
    }
    return list.dump(1) + "\n";
}

}  // namespace terray::cli
