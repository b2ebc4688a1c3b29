// SPDX-License-Identifier: Apache-2.0
// A container file being written: header, packets, trailer; whole or not at all.
#pragma once

#include <memory>
#include <string>

#include "film/av_handles.h"
#include "image/partial_file.h"

namespace terray {

/// confined.
class FilmOutput {
public:
    /// Under a temporary name; call stream() to describe it, then start().
    static Result<std::unique_ptr<FilmOutput>> create(const std::string& path,
                                                      const FilmSpec& spec);

    AVStream& stream() { return *context_->streams[0]; }
    bool wantsGlobalHeader() const { return (context_->oformat->flags & AVFMT_GLOBALHEADER) != 0; }
    /// `fastStart`: the index goes to the front, for players that begin before they have it all.
    Result<void> start(bool fastStart);
    /// Times of the packet count frames; it is left empty.
    Result<void> write(AVPacket& packet);
    /// Trailer, and the file's name.
    Result<void> finish();
    Error writeError(int code) const { return file_->writeError(avErrorText(code)); }

private:
    std::unique_ptr<PartialFile> file_;
    AvOutputHandle context_;
    AVRational frame_{1, 30};  ///< seconds of a frame
};

}  // namespace terray
