#include "daemon/commands/operator_dialogue.hpp"

#include <poll.h>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "daemon/campaign/lead/campaign.hpp"
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

CampaignLines::CampaignLines(const campaign::Engine& engine, const std::vector<campaign::Point>& points,
                             std::vector<double> bench_s)
    : engine_{engine},
      points_{points},
      bench_s_{std::move(bench_s)},
      terminal_{::isatty(STDOUT_FILENO) == 1} {}

CampaignLines::~CampaignLines() {
    if (terminal_) std::fputs(clear_line, stdout);
    std::fflush(stdout);
}

void CampaignLines::print(const std::string& line) {
    if (terminal_) std::fputs(clear_line, stdout);
    report::say(line + "\n");
    std::fflush(stdout);
    written_s_ = -1;
}

void CampaignLines::say(const std::string& sentence) { print(sentence); }

void CampaignLines::event(const campaign::Event& event, double now_s) {
    if (const auto* ended = std::get_if<campaign::PointEnded>(&event)) {
        ended_.at(static_cast<std::size_t>(ended->point - 1)) = true;
        if (ended->outcome == campaign::Outcome::measured) {
            const auto v_D = engine_.result(ended->point);
            last_ = fmt::format("v_D {:+.4f} +- {:.4f} mm/s", 1e3 * v_D.value, 1e3 * v_D.sigma);
        }
    } else if (const auto* lost = std::get_if<campaign::PassLost>(&event)) {
        ended_.at(static_cast<std::size_t>(lost->point - 1)) = false;
    }
    if (const std::string text = campaign::text(event, engine_, points_); !text.empty())
        print(fmt::format("{:7.1f} s  {}", now_s, text));
}

double CampaignLines::left_s(double spent_s) const {
    double left = 0, ended = 0;
    for (std::size_t i = 0; i < bench_s_.size(); ++i) (ended_[i] ? ended : left) += bench_s_[i];
    return ended > 0 ? left * spent_s / ended : left;
}

void CampaignLines::status(double spent_s) {
    if (!terminal_ || monotonic_s() < written_s_ + refresh_s) return;
    written_s_ = monotonic_s();
    const campaign::Point* p = engine_.point();
    const std::string where =
        p == nullptr ? std::string{"all points have ended"}
                     : fmt::format("point {} of {}  {}", p->id, points_.size(), campaign::place(*p));
    std::fputs(clear_line, stdout);
    report::say(fmt::format("{}  {}  {}{} left  {}", where, engine_.doing(),
                            engine_.known_mu().empty() ? "" : "at most ", duration_text(left_s(spent_s)),
                            last_));
    std::fflush(stdout);
}

namespace {

std::string truth_sentence(const campaign::PointsTable& table) {
    std::size_t with_truth = 0, far = 0;
    double squares = 0, worst = 0;
    int worst_point = 0;
    for (const campaign::PointRow& row : table.points) {
        if (row.outcome != campaign::outcome_words[0] || !std::isfinite(row.true_v_D)) continue;
        const double z = (row.v_D.value - row.true_v_D) / row.v_D.sigma;
        ++with_truth;
        squares += z * z;
        if (std::abs(z) > 3) ++far;
        if (std::abs(z) > std::abs(worst)) worst = z, worst_point = row.point;
    }
    if (with_truth == 0) return {};
    return fmt::format(
        "measured minus simulated truth: {:.2f} standard errors rms; {} of {} points beyond 3; "
        "the farthest is point {} with {:+.2f}\n",
        std::sqrt(squares / static_cast<double>(with_truth)), far, with_truth, worst_point, worst);
}

std::string return_sentence(const std::vector<campaign::Returned>& returns) {
    if (returns.empty()) return {};
    std::vector<double> errors_mm;
    for (const campaign::Returned& r : returns) errors_mm.push_back(1e3 * std::abs(r.x_to_m - r.x_asked_m));
    std::ranges::sort(errors_mm);
    return fmt::format(
        "{} returns; the walker turned {:.2f} mm from its target at the median, {:.2f} mm at "
        "most\n",
        errors_mm.size(), errors_mm[errors_mm.size() / 2], errors_mm.back());
}

}  // namespace

std::string campaign_summary(const campaign::PointsTable& table, const campaign::BenchTime& time,
                             const std::vector<campaign::Returned>& returns, double wall_s) {
    const auto measured =
        std::ranges::count(table.points, campaign::outcome_words[0], &campaign::PointRow::outcome);
    return fmt::format(
               "{} of {} points measured; {:.0f} s of bench time in {:.0f} s: measuring {:.0f} s, "
               "settling {:.0f} s, returning {:.0f} s, starting and checking {:.0f} s\n",
               measured, table.points.size(), time.sum(), wall_s, time.measuring, time.settling,
               time.returning, time.checking) +
           return_sentence(returns) + truth_sentence(table);
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
