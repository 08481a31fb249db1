#pragma once
// A recording that appears under its name only when it is complete.
#include <filesystem>
#include <memory>

#include "daemon/recorder.hpp"
#include "drivers/replay/session_file.hpp"

namespace shaker {

/// Writes FILE.part and renames it to FILE on finish(). Without a file name everything here does nothing.
class Recording {
public:
    /// What becomes of FILE.part when finish() is never reached: a live run's data exist nowhere else.
    enum class Unfinished { keep, discard };
    Recording(const std::filesystem::path& file, const SessionHeader& header, Unfinished unfinished);
    ~Recording();
    Recording(const Recording&) = delete;
    Recording& operator=(const Recording&) = delete;
    /// Null when nothing is recorded.
    [[nodiscard]] SessionWriter* writer() noexcept { return writer_.get(); }
    /// Adds tracks, results and the part of master time they were made from, and completes the file.
    void finish(const Take& take, const Reduction& reduction, double from_s, double to_s);
    /// Adds tracks and completes the file.
    void finish(const Take& take);

private:
    std::filesystem::path file_, part_;
    Unfinished unfinished_;
    std::unique_ptr<SessionWriter> writer_;
};

}  // namespace shaker
