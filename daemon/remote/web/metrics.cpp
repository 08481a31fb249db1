#include "daemon/remote/web/metrics.hpp"

#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <iterator>
#include <string_view>
#include <variant>

#include "daemon/remote/web/state_json.hpp"
#include "daemon/service/published.hpp"

namespace shaker::web {

namespace {

// Escapes backslash, quote and line feed in a label's value; nothing else is special.
std::string escaped(std::string_view value) {
    std::string out;
    for (const char c : value) {
        if (c == '\n')
            out += "\\n";
        else if (c == '"' || c == '\\')
            out += std::string{'\\', c};
        else
            out += c;
    }
    return out;
}

std::string number(double x) {
    if (std::isnan(x)) return "NaN";
    if (std::isinf(x)) return x > 0 ? "+Inf" : "-Inf";
    return fmt::format("{}", x);
}

class Text {
public:
    explicit Text(MetricsFormat format) : format_{format} {}
    void family(std::string_view name, std::string_view type, std::string_view help) {
        name_ = fmt::format("shakerd_{}", name);
        std::string_view of = name_;  // OpenMetrics names a counter without the end of its samples
        if (format_ == MetricsFormat::open && type == "counter")
            of.remove_suffix(std::string_view{"_total"}.size());
        fmt::format_to(std::back_inserter(text_), "# HELP {} {}\n# TYPE {} {}\n", of, help, of, type);
    }
    void sample(double value) { text_ += name_ + ' ' + number(value) + '\n'; }
    void sample(std::string_view label, std::string_view of, double value) {
        fmt::format_to(std::back_inserter(text_), "{}{{{}=\"{}\"}} {}\n", name_, label, escaped(of),
                       number(value));
    }
    void counter(std::string_view name, std::string_view help, std::uint64_t value) {
        family(name, "counter", help);
        sample(static_cast<double>(value));
    }
    /// Counts per bin with the given upper ends, and one for values above the last.
    void histogram(std::string_view name, std::string_view help,
                   const acquisition::PeriodJitter::Seen& seen) {
        family(name, "histogram", help);
        std::uint64_t below = 0;
        const auto bucket = [&](std::string_view end, std::uint64_t count) {
            below += count;
            fmt::format_to(std::back_inserter(text_), "{}_bucket{{le=\"{}\"}} {}\n", name_, end, below);
        };
        for (std::size_t i = 0; i < acquisition::PeriodJitter::ends_s.size(); ++i)
            bucket(number(acquisition::PeriodJitter::ends_s[i]), seen.counts[i]);
        bucket("+Inf", seen.counts.back());
        fmt::format_to(std::back_inserter(text_), "{}_sum {}\n{}_count {}\n", name_, number(seen.sum_s),
                       name_, below);
    }
    [[nodiscard]] std::string take() {
        if (format_ == MetricsFormat::open) text_ += "# EOF\n";
        return std::move(text_);
    }

private:
    MetricsFormat format_;
    std::string name_, text_;
};

void put_streams(Text& t, const service::BenchState& s) {
    const auto each = [&](const char* name, const char* help, auto value) {
        t.family(name, "counter", help);
        for (const DeviceReport& d : s.devices)
            t.sample("stream", d.device, static_cast<double>(value(d.counts)));
    };
    each("stream_taken_total", "Samples or frames received or played.",
         [](const DeviceCounts& c) { return c.taken; });
    each("stream_lost_total", "Lost samples or frames.", [](const DeviceCounts& c) { return c.lost; });
    each("stream_incidents_total", "Underruns, broken connections, jumps of stamps.",
         [](const DeviceCounts& c) { return c.incidents; });
    each("stream_reopened_total", "Number of times devices were reopened.",
         [](const DeviceCounts& c) { return c.reopened; });
    t.family("queue_lost_total", "counter", "Items lost because a queue between two threads was full.");
    const service::LostState& l = s.lost;
    for (const auto& [queue, n] :
         {std::pair{"plays", l.plays}, std::pair{"changes", l.changes}, std::pair{"blocks", l.blocks},
          std::pair{"frames", l.frames}, std::pair{"trips", l.trips}})
        t.sample("queue", queue, static_cast<double>(n));
}

void put_clocks(Text& t, const service::BenchState& s) {
    t.family("clock_offset_ppm", "gauge", "Relative error of a clock; positive: fast.");
    for (const service::ClockState& c : s.clocks) t.sample("clock", c.name, c.ppm);
    t.family("clock_residual_seconds", "gauge", "Mean delay of its stamps above the shortest delay.");
    for (const service::ClockState& c : s.clocks) t.sample("clock", c.name, c.residual_s);
}

void put_published(Text& t, const service::BenchState& s) {
    for (const service::Published& row : service::published_quantities()) {
        if (row.metric == nullptr) continue;
        const auto put = [&]<class T>(T value) {
            if constexpr (!std::is_same_v<T, std::monostate>) {
                const std::string_view name = row.metric;
                t.family(name, name.ends_with("_total") ? "counter" : "gauge", row.help);
                t.sample(static_cast<double>(value));
            }
        };
        std::visit(put, row.value(s));
    }
}

void put_harmonics(Text& t, const service::BenchState& s) {
    if (!s.base) return;
    t.family("harmonic_error_ratio", "gauge", "Measured minus requested harmonic, as a share of gamma.");
    for (int n = 1; n <= s.base->controlled; ++n) {
        const service::HarmonicState& h = s.base->harmonics.at(static_cast<std::size_t>(n - 1));
        t.sample("n", fmt::format("{}", n), std::abs(h.measured - h.target) / s.wanted.gamma);
    }
}

void put_contact(Text& t, const service::BenchState& s) {
    if (!s.contact) return;
    t.family("abort_contact", "gauge", "1 for the present state of the abort input's contact.");
    for (const Contact c : {Contact::closed, Contact::open, Contact::unreadable})
        t.sample("state", service::word_of(c), c == *s.contact ? 1 : 0);
}

}  // namespace

std::string metrics_text(const service::BenchState* state, const ServedCounts& served, MetricsFormat format) {
    Text t{format};
    t.family("build_info", "gauge", "The program.");
    t.sample("version", SHAKER_VERSION, 1);
    t.counter("http_requests_total", "Answered requests.", served.requests);
    t.counter("http_refused_total", "Refused requests.", served.refused_requests);
    t.counter("stream_messages_dropped_total", "Live messages not sent to slow clients.",
              served.messages_dropped);
    t.counter("scpi_messages_total", "SCPI messages received.", served.scpi_commands);
    t.counter("scpi_errors_total", "SCPI errors reported.", served.scpi_errors);
    t.counter("remote_failures_total", "Internal errors of the remote control.", served.troubles);
    t.family("clients", "gauge", "Connected clients.");
    t.sample("kind", "web", served.web_clients);
    t.sample("kind", "scpi", served.scpi_clients);
    if (state == nullptr) return t.take();
    const service::BenchState& s = *state;
    t.family("state", "gauge", "1 for the present state of the bench.");
    for (int k = 0; k < run::run_states; ++k) {
        const auto which = static_cast<run::RunState>(k);
        t.sample("state", name(which), which == s.state ? 1 : 0);
    }
    put_published(t, s);
    put_harmonics(t, s);
    put_streams(t, s);
    put_clocks(t, s);
    t.family("realtime", "gauge",
             "1: locked memory, or stack and priority of a thread, granted; 0: refused.");
    for (const acquisition::RealTimeGrant& g : s.real_time)
        t.sample("what", g.what, g.refused.empty() ? 1 : 0);
    put_contact(t, s);
    t.histogram("output_period_jitter_seconds",
                "Deviation of the time between two blocks of the drive from a block's length.", s.jitter);
    return t.take();
}

}  // namespace shaker::web
