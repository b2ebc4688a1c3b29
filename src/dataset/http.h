// SPDX-License-Identifier: Apache-2.0
// GDAL's HTTP client on a thread of its own, so that who asks can leave a server that says nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace terray {

struct HttpReply {
    std::vector<std::byte> bytes;
    std::optional<uint64_t> firstByte;  ///< of a part of a file
    std::string failure;                ///< why there is no good answer; empty: none
    bool isPermanent = false;           ///< asking again will not help
};

/// Keeps a connection open. Nothing is cached or asked twice. confined.
class HttpClient {
public:
    HttpClient();
    ~HttpClient();
    HttpClient(const HttpClient&) = delete;
    HttpClient& operator=(const HttpClient&) = delete;

    /// GET, of a range ("0-99") unless it is empty, of at most `most` bytes. Once mustEnd() is
    /// true, returns a failure at once.
    HttpReply get(const std::string& url, const std::string& range, uint64_t most,
                  const std::function<bool()>& mustEnd);

private:
    struct Worker;
    void leave();
    std::shared_ptr<Worker> worker_;
};

}  // namespace terray
