#pragma once
// Dates of recordings as ISO 8601 text with the offset from UTC, to the second.
#include <string>

namespace shaker::recording {

/// Now, in local time.
std::string local_time_text();
/// Of a run on virtual time, which has no date: equal runs make equal recordings.
inline constexpr const char* epoch_text = "1970-01-01T00:00:00+00:00";
/// The instant `s` seconds after such a text, with the same offset; empty when it is not one.
std::string time_text_after(const std::string& text, double s);

}  // namespace shaker::recording
