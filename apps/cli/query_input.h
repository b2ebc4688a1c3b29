// SPDX-License-Identifier: Apache-2.0
// Places, rays and pairs for `terray query`: from arguments, CSV or JSON.
#pragma once

#include <string>
#include <vector>

namespace terray::cli {

/// A named column; the other names are accepted in headers and JSON keys too.
struct Column {
    std::string name;
    std::vector<std::string> otherNames;
    bool required = true;
};

/// One question: its values as text, one for each column; empty where nothing was given.
using Record = std::vector<std::string>;

/// `arguments` are records with commas between the values. `file`: CSV or JSON (recognised by its
/// first character), "-" for standard input, empty for none. A CSV file may start with a header
/// line that names columns; without one they are in the order of `columns`.
std::vector<Record> readRecords(const std::vector<std::string>& arguments, const std::string& file,
                                const std::vector<Column>& columns);

}  // namespace terray::cli
