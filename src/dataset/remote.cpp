// SPDX-License-Identifier: Apache-2.0
// URLs and GDAL's names for them.
#include "dataset/remote.h"

#include <array>
#include <string_view>
#include <utility>

namespace terray {
namespace {

using std::string_view_literals::operator""sv;

constexpr std::string_view kCurl = "/vsicurl/";
constexpr std::array kBuckets{std::pair{"s3://"sv, "/vsis3/"sv}, std::pair{"gs://"sv, "/vsigs/"sv}};
constexpr std::array kNetworks{"/vsicurl"sv,  "/vsis3"sv,   "/vsigs"sv,
                               "/vsiaz"sv,    "/vsiadls"sv, "/vsioss"sv,
                               "/vsiswift"sv, "/vsihdfs"sv, "/vsiwebhdfs"sv};

bool isHttp(std::string_view name) {
    return name.starts_with("http://") || name.starts_with("https://");
}

}  // namespace

std::string gdalName(const std::string& source) {
    if (isHttp(source)) return std::string(kCurl) + source;
    for (const auto& [scheme, folder] : kBuckets) {
        if (source.starts_with(scheme)) return std::string(folder) + source.substr(scheme.size());
    }
    return source;
}

std::string httpUrl(const std::string& source) {
    if (isHttp(source)) return source;
    if (!source.starts_with(kCurl)) return {};
    const std::string url = source.substr(kCurl.size());
    return isHttp(url) ? url : std::string();
}

bool isRemote(const std::string& source) {
    const std::string name = gdalName(source);
    for (const std::string_view network : kNetworks) {
        if (name.starts_with(network)) return true;
    }
    return false;
}

std::string fileIn(const std::string& folder, const std::string& name) {
    const size_t query = httpUrl(folder).empty() ? std::string::npos : folder.find('?');
    std::string path = folder.substr(0, query);
    if (!path.ends_with('/')) path += '/';
    return path + name + (query == std::string::npos ? "" : folder.substr(query));
}

std::string shownName(const std::string& source) {
    if (httpUrl(source).empty()) return source;
    std::string shown = source.substr(0, source.find('?'));
    const size_t host = shown.find("://") + 3;
    const size_t user = shown.substr(0, shown.find('/', host)).rfind('@');
    if (user != std::string::npos) shown.erase(host, user + 1 - host);
    return shown;
}

}  // namespace terray
