#include "daemon/commands/operator_dialogue.hpp"

#include <poll.h>
#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "daemon/report/printing.hpp"

namespace shaker::commands {

namespace {

constexpr double refresh_s = 0.2;
constexpr const char* clear_line = "\r\033[K";

double monotonic_s() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::string duration_text(double s) {
    const auto whole = std::llround(s);
    if (whole < 60) return fmt::format("{} s", whole);
    if (whole < 3600) return fmt::format("{}:{:02} min", whole / 60, whole % 60);
    return fmt::format("{}:{:02} h", whole / 3600, whole % 3600 / 60);
}

}  // namespace

CampaignLines::CampaignLines(const service::BenchPort& port, std::FILE* to)
    : port_{port}, to_{to}, terminal_{::isatty(::fileno(to)) == 1} {}

CampaignLines::~CampaignLines() {
    if (terminal_) std::fputs(clear_line, to_);
    std::fflush(to_);
}

void CampaignLines::say(const std::string& sentence) {
    if (terminal_) std::fputs(clear_line, to_);
    report::say(sentence + "\n", to_);
    std::fflush(to_);
    written_s_ = -1;
}

void CampaignLines::follow() {
    for (const service::BenchEvent& e : port_.events(seen_)) {
        seen_ = e.number;
        if (e.kind == "campaign") say(fmt::format("{:7.1f} s  {}", e.t_s, e.text));
        if (e.kind == "trip" || e.kind == "warning") spdlog::warn("{:.3f} s {}: {}", e.t_s, e.kind, e.text);
    }
    if (const auto state = port_.state(); state && state->campaign) status(*state->campaign);
}

void CampaignLines::status(const service::CampaignState& campaign) {
    if (!terminal_ || monotonic_s() < written_s_ + refresh_s) return;
    written_s_ = monotonic_s();
    const std::string where = campaign.number == 0 ? std::string{"all points have ended"}
                                                   : fmt::format("point {} of {}  {}", campaign.number,
                                                                 campaign.points, campaign.point);
    std::fputs(clear_line, to_);
    report::say(fmt::format("{}  {}  {}{} left", where, campaign.doing,
                            campaign.known_mu.empty() ? "" : "at most ", duration_text(campaign.left_s)),
                to_);
    std::fflush(to_);
}

OperatorInput::OperatorInput(Keys keys) : keys_{std::move(keys)} {
    termios now{};
    if (::isatty(STDIN_FILENO) != 1 || ::tcgetattr(STDIN_FILENO, &now) != 0) return;
    closed_ = ::tcgetpgrp(STDIN_FILENO) != ::getpgrp();
    if (closed_) return;
    before_ = now;
    now.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
    ::tcsetattr(STDIN_FILENO, TCSANOW, &now);
}

OperatorInput::~OperatorInput() {
    if (before_) ::tcsetattr(STDIN_FILENO, TCSANOW, &*before_);
}

std::optional<std::string> OperatorInput::word_in_text() {
    if (keys()) {
        if (text_.empty()) return std::nullopt;
        const char key = text_.front();
        text_.erase(0, 1);
        const auto known = std::ranges::find(keys_, key, &std::pair<char, std::string>::first);
        return known == keys_.end() ? std::string{key} : known->second;
    }
    const std::size_t end = text_.find('\n');
    if (end == std::string::npos) return std::nullopt;
    std::string line = text_.substr(0, end);
    text_.erase(0, end + 1);
    return line;
}

std::optional<std::string> OperatorInput::next(bool waits) {
    for (;;) {
        if (auto word = word_in_text()) return word;
        if (closed_) return std::nullopt;
        pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
        if (poll(&input, 1, waits ? -1 : 0) <= 0) return std::nullopt;
        std::array<char, 256> some{};
        const ssize_t n = read(STDIN_FILENO, some.data(), some.size());
        if (n <= 0)
            closed_ = true;
        else
            text_.append(some.data(), static_cast<std::size_t>(n));
    }
}

}  // namespace shaker::commands
