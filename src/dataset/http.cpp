// SPDX-License-Identifier: Apache-2.0
// One request at a time, handed to a thread that is left behind where it hangs: it then ends by
// itself with the time that GDAL allows a silent server.
#include "dataset/http.h"

#include <cpl_http.h>
#include <cpl_string.h>
#include <fmt/format.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <thread>

#include "dataset/gdal_handle.h"

namespace terray {
namespace {

constexpr std::chrono::milliseconds kLook{20};  ///< between looks whether it must end

struct Request {
    std::string url, range;
    uint64_t most = 0;
};

/// Where the bytes of one answer go.
struct Answer {
    std::vector<std::byte> bytes;
    uint64_t most = 0;
    bool isTooLong = false;
};

size_t takeBytes(void* data, size_t size, size_t count, void* user) {
    Answer& answer = *static_cast<Answer*>(user);
    const size_t bytes = size * count;
    if (answer.bytes.size() + bytes > answer.most) {
        answer.isTooLong = true;
        return 0;
    }
    const auto* from = static_cast<const std::byte*>(data);
    answer.bytes.insert(answer.bytes.end(), from, from + bytes);
    return bytes;
}

/// "bytes 100-199/2000"
std::optional<uint64_t> firstByteOf(const CPLHTTPResult& result) {
    const char* range = CSLFetchNameValue(result.papszHeaders, "Content-Range");
    unsigned long long first = 0;
    if (range == nullptr || std::sscanf(range, "bytes %llu-", &first) != 1) return std::nullopt;
    return first;
}

bool isPermanentStatus(int status) {
    constexpr int kTimeout = 408, kTooEarly = 425, kTooMany = 429;
    return status >= 400 && status < 500 && status != kTimeout && status != kTooEarly &&
           status != kTooMany;
}

/// GDAL says "HTTP error code : 503".
std::string failureOf(const CPLHTTPResult& result, const Answer& answer, int& status) {
    if (answer.isTooLong) return "the server sends more than was asked for";
    if (result.pszErrBuf == nullptr && result.nStatus == 0) return {};
    const std::string text = result.pszErrBuf != nullptr ? result.pszErrBuf : gdalMessage();
    const size_t code = text.rfind(": ");
    if (text.starts_with("HTTP error code") && code != std::string::npos) {
        status = std::atoi(text.c_str() + code + 2);
        return fmt::format("the server answers with HTTP status {}", status);
    }
    return text.empty() ? fmt::format("no connection (curl error {})", result.nStatus) : text;
}

HttpReply fetch(const Request& request, const std::string& session) {
    clearGdalMessage();
    CPLStringList options;
    options.SetNameValue("PERSISTENT", session.c_str());
    options.SetNameValue("MAX_RETRY", "0");
    if (!request.range.empty()) {
        options.SetNameValue("HEADERS", ("Range: bytes=" + request.range).c_str());
    }
    Answer answer;
    answer.most = request.most;
    CPLHTTPResult* result =
        CPLHTTPFetchEx(request.url.c_str(), options.List(), nullptr, nullptr, &takeBytes, &answer);
    HttpReply reply;
    if (result == nullptr) {
        reply.failure = gdalMessage();
        return reply;
    }
    int status = 0;
    reply.failure = failureOf(*result, answer, status);
    reply.isPermanent = isPermanentStatus(status);
    reply.firstByte = firstByteOf(*result);
    reply.bytes = std::move(answer.bytes);
    CPLHTTPDestroyResult(result);
    return reply;
}

void closeSession(const std::string& session) {
    CPLStringList options;
    options.SetNameValue("CLOSE_PERSISTENT", session.c_str());
    CPLHTTPDestroyResult(CPLHTTPFetch("", options.List()));
}

}  // namespace

struct HttpClient::Worker {
    std::mutex mutex;
    std::condition_variable asked, done;
    std::optional<Request> request;
    std::optional<HttpReply> reply;
    bool mustQuit = false;
    std::thread thread;

    static void work(const std::shared_ptr<Worker>& worker) {
        static std::atomic<uint64_t> sessions{0};
        const std::string session = fmt::format("terray{}", sessions++);
        std::unique_lock lock(worker->mutex);
        while (true) {
            worker->asked.wait(lock, [&] { return worker->mustQuit || worker->request; });
            if (worker->mustQuit) break;
            const Request request = std::move(*worker->request);
            worker->request.reset();
            lock.unlock();
            HttpReply reply = fetch(request, session);
            // A connection on which something went wrong is not used again.
            if (!reply.failure.empty()) closeSession(session);
            lock.lock();
            worker->reply = std::move(reply);
            worker->done.notify_all();
        }
        lock.unlock();
        closeSession(session);
    }
};

HttpClient::HttpClient() = default;
HttpClient::~HttpClient() {
    if (!worker_) return;
    std::thread thread = std::move(worker_->thread);
    leave();
    thread.join();  // it is idle: get() has returned
}

/// The worker ends after what it is doing, on its own.
void HttpClient::leave() {
    {
        const std::lock_guard lock(worker_->mutex);
        worker_->mustQuit = true;
    }
    worker_->asked.notify_all();
    if (worker_->thread.joinable()) worker_->thread.detach();
    worker_.reset();
}

HttpReply HttpClient::get(const std::string& url, const std::string& range, uint64_t most,
                          const std::function<bool()>& mustEnd) {
    HttpReply failed;
    failed.failure = "interrupted";
    if (mustEnd()) return failed;
    if (!worker_) {
        worker_ = std::make_shared<Worker>();
        worker_->thread = std::thread([worker = worker_] { Worker::work(worker); });
    }
    std::unique_lock lock(worker_->mutex);
    worker_->reply.reset();
    worker_->request = Request{url, range, most};
    worker_->asked.notify_all();
    while (!worker_->done.wait_for(lock, kLook, [&] { return worker_->reply.has_value(); })) {
        if (!mustEnd()) continue;
        lock.unlock();
        leave();
        return failed;
    }
    return std::move(*worker_->reply);
}

}  // namespace terray
