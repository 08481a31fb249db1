#pragma once
// Dates of recordings as ISO 8601 text with the offset from UTC, to the second.
#include <string>

namespace shaker::recording {

/// The present time, with the local offset.
std::string local_time_text();
/// Date of a run on virtual time. It is constant, so that equal runs make equal recordings.
inline constexpr const char* epoch_text = "1970-01-01T00:00:00+00:00";
/// The instant `s` seconds after `text`, with the same offset; empty when `text` is not such a date.
std::string time_text_after(const std::string& text, double s);
/// Seconds of that instant since 1970 in UTC; NaN when `text` is not such a date.
double seconds_of(const std::string& text);
/// The same instant as UTC, "2026-11-26T19:43:32Z"; empty when `text` is not such a date.
std::string utc_text(const std::string& text);
/// The instant `s` seconds ago as UTC.
std::string utc_text_ago(double s);

}  // namespace shaker::recording
