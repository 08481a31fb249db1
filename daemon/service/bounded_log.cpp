#include "daemon/service/bounded_log.hpp"

#include <poll.h>
#include <spdlog/async.h>
#include <spdlog/fmt/fmt.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/sinks/systemd_sink.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <climits>
#include <cstdlib>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>

#include "daemon/report/printing.hpp"
#include "drivers/text/printable.hpp"

namespace shaker::service {

namespace {

constexpr std::size_t most_waiting = 8192;  // messages

class BoundedSink final : public spdlog::sinks::base_sink<std::mutex> {
public:
    BoundedSink(std::shared_ptr<spdlog::sinks::sink> inner, LogRate rate)
        : inner_{std::move(inner)}, rate_{rate}, left_{static_cast<double>(rate.burst)} {}

protected:
    void sink_it_(const spdlog::details::log_msg& message) override {
        const double passed = std::chrono::duration<double>{message.time - last_}.count();
        last_ = message.time;
        left_ = std::min(static_cast<double>(rate_.burst), left_ + rate_.per_s * std::max(0.0, passed));
        if (left_ < 1 && message.level < spdlog::level::err) {
            ++left_out_;
            return;
        }
        left_ = std::max(0.0, left_ - 1);
        std::string text = printable({message.payload.data(), message.payload.size()});
        if (const auto n = std::exchange(left_out_, 0))
            text += fmt::format(" ({} messages before this one were left out: too many at once)", n);
        spdlog::details::log_msg cleaned = message;
        cleaned.payload = text;
        inner_->log(cleaned);
    }
    void flush_() override { inner_->flush(); }
    void set_pattern_(const std::string& pattern) override { inner_->set_pattern(pattern); }
    void set_formatter_(std::unique_ptr<spdlog::formatter> formatter) override {
        inner_->set_formatter(std::move(formatter));
    }

private:
    std::shared_ptr<spdlog::sinks::sink> inner_;
    LogRate rate_;
    double left_;
    std::uint64_t left_out_ = 0;
    spdlog::log_clock::time_point last_ = spdlog::log_clock::now();
};

}  // namespace

/// Standard error. A pipe that nobody reads is waited for, but at the end of the program only for a moment.
class StandardError final : public spdlog::sinks::base_sink<std::mutex> {
    using Clock = std::chrono::steady_clock;

public:
    void end() noexcept { until_ = Clock::now() + std::chrono::seconds{1}; }

protected:
    void sink_it_(const spdlog::details::log_msg& message) override {
        constexpr int turn_ms = 100;
        spdlog::memory_buf_t text;
        formatter_->format(message, text);
        for (std::string_view rest{text.data(), text.size()}; !rest.empty();) {
            pollfd ready{.fd = STDERR_FILENO, .events = POLLOUT, .revents = 0};
            const bool over = Clock::now() > until_.load();
            if (::poll(&ready, 1, over ? 0 : turn_ms) == 0) {
                if (over) return;
                continue;
            }
            // So much fits into a pipe that is ready.
            const ssize_t n =
                ::write(STDERR_FILENO, rest.data(), std::min<std::size_t>(rest.size(), PIPE_BUF));
            if (n < 0 && errno == EINTR) continue;
            if (n <= 0) return;
            rest.remove_prefix(static_cast<std::size_t>(n));
        }
    }
    void flush_() override {}

private:
    std::atomic<Clock::time_point> until_{Clock::time_point::max()};
};

std::shared_ptr<spdlog::sinks::sink> bounded_sink(std::shared_ptr<spdlog::sinks::sink> inner, LogRate rate) {
    return std::make_shared<BoundedSink>(std::move(inner), rate);
}

BoundedLog::BoundedLog() {
    std::shared_ptr<spdlog::sinks::sink> sink;
    if (std::getenv("JOURNAL_STREAM") != nullptr)
        sink = std::make_shared<spdlog::sinks::systemd_sink_mt>("shakerd");
    else
        sink = standard_error_ = std::make_shared<StandardError>();
    spdlog::init_thread_pool(most_waiting, 1);
    auto logger = std::make_shared<spdlog::async_logger>("daemon", bounded_sink(std::move(sink), {}),
                                                         spdlog::thread_pool(),
                                                         spdlog::async_overflow_policy::overrun_oldest);
    logger->set_pattern("%v");
    logger->flush_on(spdlog::level::info);
    spdlog::set_default_logger(std::move(logger));
}

// Later messages go directly to standard error again.
BoundedLog::~BoundedLog() {
    if (!standard_error_) standard_error_ = std::make_shared<StandardError>();
    standard_error_->end();
    auto last = std::make_shared<spdlog::logger>("shakerd", standard_error_);
    last->set_formatter(report::log_format());
    spdlog::set_default_logger(std::move(last));
    spdlog::details::registry::instance().set_tp(nullptr);
}

}  // namespace shaker::service
