#include "daemon/recording/time_text.hpp"

#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>

#include <chrono>
#include <cmath>
#include <ctime>

namespace shaker::recording {

std::string local_time_text() {
    const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
    const std::string text = fmt::format("{:%Y-%m-%dT%H:%M:%S%z}", fmt::localtime(now));
    return text.substr(0, text.size() - 2) + ":" + text.substr(text.size() - 2);
}

std::string time_text_after(const std::string& text, double s) {
    std::tm fields{};
    const char* offset = strptime(text.c_str(), "%Y-%m-%dT%H:%M:%S", &fields);
    if (offset == nullptr || !std::isfinite(s)) return {};
    const std::time_t then = timegm(&fields) + static_cast<std::time_t>(std::llround(s));
    return fmt::format("{:%Y-%m-%dT%H:%M:%S}{}", fmt::gmtime(then), offset);
}

namespace {

std::string in_utc(std::time_t time) { return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(time)); }

}  // namespace

double seconds_of(const std::string& text) {
    std::tm fields{};
    const char* end = strptime(text.c_str(), "%Y-%m-%dT%H:%M:%S%z", &fields);
    if (end == nullptr || *end != 0) return NAN;
    const long offset = fields.tm_gmtoff;  // timegm() clears it
    return static_cast<double>(timegm(&fields) - offset);
}

std::string utc_text(const std::string& text) {
    const double s = seconds_of(text);
    return std::isnan(s) ? std::string{} : in_utc(static_cast<std::time_t>(s));
}

std::string utc_text_ago(double s) {
    const auto now = std::chrono::system_clock::now() - std::chrono::milliseconds{std::llround(1e3 * s)};
    return in_utc(std::chrono::system_clock::to_time_t(
        std::chrono::time_point_cast<std::chrono::system_clock::duration>(now)));
}

}  // namespace shaker::recording
