// SPDX-License-Identifier: Apache-2.0
// Reading questions.
#include "query_input.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "parse.h"
#include "usage.h"

namespace terray::cli {
namespace {

using nlohmann::json;

std::string lowerCase(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return text;
}

std::string namesOf(const std::vector<Column>& columns) {
    std::string names;
    for (const Column& c : columns) names += (names.empty() ? "" : ",") + c.name;
    return names;
}

std::optional<size_t> columnNamed(const std::string& name, const std::vector<Column>& columns) {
    const std::string wanted = lowerCase(name);
    for (size_t k = 0; k < columns.size(); ++k) {
        const auto& others = columns[k].otherNames;
        if (columns[k].name == wanted ||
            std::find(others.begin(), others.end(), wanted) != others.end())
            return k;
    }
    return std::nullopt;
}

/// Values in the order of the columns; the last optional ones may be left out.
Record byPosition(const std::vector<std::string>& values, const std::vector<Column>& columns,
                  const std::string& where) {
    if (values.size() > columns.size())
        failUsage(fmt::format("{}: {} values are too many; give {}", where, values.size(),
                              namesOf(columns)));
    Record record = values;
    record.resize(columns.size());
    return record;
}

void checkRecord(const Record& record, const std::vector<Column>& columns, ErrorCode code,
                 const std::string& where) {
    for (size_t k = 0; k < columns.size(); ++k)
        if (columns[k].required && record[k].empty())
            fail(code, fmt::format("{}: '{}' is missing; give {}", where, columns[k].name,
                                   namesOf(columns)));
}

std::string readAll(const std::string& file) {
    std::FILE* in = file == "-" ? stdin : std::fopen(file.c_str(), "rb");
    if (in == nullptr)
        fail(ErrorCode::Input, fmt::format("--from: cannot read '{}'; check its name", file));
    std::string text;
    char buffer[1 << 16];
    for (size_t n = 0; (n = std::fread(buffer, 1, sizeof buffer, in)) > 0;) text.append(buffer, n);
    const bool good = std::ferror(in) == 0;
    if (in != stdin) std::fclose(in);
    if (!good)
        fail(ErrorCode::Input,
             fmt::format("--from: cannot read '{}'; check that it is a file", file));
    return text;
}

bool isHeader(const std::vector<std::string>& values) {
    return !values.empty() && !values[0].empty() &&
           std::isalpha(static_cast<unsigned char>(values[0][0])) != 0;
}

std::vector<size_t> readHeader(const std::vector<std::string>& names,
                               const std::vector<Column>& columns, const std::string& where) {
    std::vector<size_t> order;
    for (const std::string& name : names) {
        const auto column = columnNamed(name, columns);
        order.push_back(column.value_or(columns.size()));
    }
    for (size_t k = 0; k < columns.size(); ++k)
        if (columns[k].required && std::find(order.begin(), order.end(), k) == order.end())
            fail(ErrorCode::Input, fmt::format("{}: there is no column '{}'; name the columns {}",
                                               where, columns[k].name, namesOf(columns)));
    return order;
}

/// Fields of a line of CSV; quotes may stand around them and keep commas.
std::vector<std::string> csvFields(const std::string& line) {
    std::vector<std::string> fields(1);
    bool quoted = false;
    for (const char c : line) {
        if (c == '"')
            quoted = !quoted;
        else if (c == ',' && !quoted)
            fields.emplace_back();
        else
            fields.back() += c;
    }
    for (std::string& field : fields) field = trimmed(field);
    return fields;
}

void readCsv(const std::string& text, const std::string& file, const std::vector<Column>& columns,
             std::vector<Record>& records) {
    std::optional<std::vector<size_t>> order;
    size_t number = 0;
    for (const std::string& line : split(text, '\n')) {
        ++number;
        if (line.empty() || line[0] == '#') continue;
        const std::string where = fmt::format("'{}' line {}", file, number);
        const std::vector<std::string> values = csvFields(line);
        if (records.empty() && !order && isHeader(values)) {
            order = readHeader(values, columns, where);
            continue;
        }
        Record record(columns.size());
        if (order) {
            for (size_t k = 0; k < std::min(values.size(), order->size()); ++k)
                if ((*order)[k] < columns.size()) record[(*order)[k]] = values[k];
        } else {
            record = byPosition(values, columns, where);
        }
        checkRecord(record, columns, ErrorCode::Input, where);
        records.push_back(std::move(record));
    }
}

std::string scalarText(const json& value, const std::string& where) {
    if (value.is_string()) return value.get<std::string>();
    if (value.is_number()) return value.dump();
    if (value.is_null()) return {};
    fail(ErrorCode::Input, fmt::format("{}: values must be numbers, or \"+H\" for heights", where));
}

Record readJsonRecord(const json& item, const std::vector<Column>& columns,
                      const std::string& where) {
    Record record(columns.size());
    if (item.is_array()) {
        std::vector<std::string> values;
        for (const json& value : item) values.push_back(scalarText(value, where));
        record = byPosition(values, columns, where);
    } else if (item.is_object()) {
        for (const auto& [key, value] : item.items())
            if (const auto column = columnNamed(key, columns))
                record[*column] = scalarText(value, where);
    } else {
        fail(ErrorCode::Input, fmt::format("{}: must be an object or an array", where));
    }
    checkRecord(record, columns, ErrorCode::Input, where);
    return record;
}

void readJson(const std::string& text, const std::string& file, const std::vector<Column>& columns,
              std::vector<Record>& records) {
    const json parsed = json::parse(text, nullptr, false);
    if (parsed.is_discarded())
        fail(ErrorCode::Input,
             fmt::format("--from: '{}' is not JSON; give an array of objects or of arrays", file));
    if (parsed.is_object()) {
        records.push_back(readJsonRecord(parsed, columns, fmt::format("'{}'", file)));
        return;
    }
    for (size_t k = 0; k < parsed.size(); ++k)
        records.push_back(
            readJsonRecord(parsed[k], columns, fmt::format("'{}' item {}", file, k + 1)));
}

}  // namespace

std::vector<Record> readRecords(const std::vector<std::string>& arguments, const std::string& file,
                                const std::vector<Column>& columns) {
    std::vector<Record> records;
    for (const std::string& argument : arguments) {
        const std::string where = fmt::format("'{}'", unmarked(argument));
        records.push_back(byPosition(split(unmarked(argument), ','), columns, where));
        checkRecord(records.back(), columns, ErrorCode::Usage, where);
    }
    if (file.empty()) return records;
    std::string text = readAll(file);
    if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);  // byte order mark, as Excel writes
    const auto first = text.find_first_not_of(" \t\r\n");
    const std::string name = file == "-" ? "standard input" : file;
    if (first != std::string::npos && (text[first] == '[' || text[first] == '{'))
        readJson(text, name, columns, records);
    else
        readCsv(text, name, columns, records);
    return records;
}

}  // namespace terray::cli
