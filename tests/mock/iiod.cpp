#include "tests/mock/iiod.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <random>
#include <thread>
#include <utility>
#include <vector>

#include "drivers/errors.hpp"
#include "drivers/realtime.hpp"
#include "tests/mock/iiod_connection.hpp"

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>

namespace shaker::mock {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

namespace {

constexpr std::uint64_t most_under_way = 1'000'000;

/// Makes stamps late like a busy processor: an interrupt waits, then all samples of that time are stamped one
/// after the other.
class LateStamps {
public:
    void set(std::int64_t most_ns) noexcept { most_ns_ = most_ns; }
    std::int64_t stamp(std::int64_t ns) {
        constexpr double bursts_a_sample = 0.005;
        constexpr std::int64_t handling_ns = 6000;
        if (most_ns_ <= 0) return ns;
        if (ns >= free_ns_ && std::bernoulli_distribution{bursts_a_sample}(rng_))
            free_ns_ = ns + std::uniform_int_distribution<std::int64_t>{0, most_ns_}(rng_);
        last_ns_ = std::max({ns, free_ns_, last_ns_ + handling_ns});
        return last_ns_;
    }

private:
    std::int64_t most_ns_ = 0;
    std::int64_t free_ns_ = 0;  // time at which the processor is free again
    std::int64_t last_ns_ = 0;
    std::mt19937_64 rng_{1};
};

}  // namespace

struct Iiod::State {
    asio::io_context io{1};
    asio::executor_work_guard<asio::io_context::executor_type> work{io.get_executor()};
    tcp::acceptor acceptor{io};
    asio::steady_timer silence_over{io};
    IiodShared shared;
    std::vector<std::shared_ptr<IiodConnection>> connections{};
    std::uint16_t port = 0;
    std::atomic<std::uint64_t> pushed{0}, dropped{0}, unheard{0}, accepted{0}, under_way{0};
    // faults
    std::uint64_t to_drop = 0, to_freeze = 0;
    std::array<std::int32_t, 3> last_counts{};
    std::int64_t shift_ns = 0;
    LateStamps late{};
    std::jthread thread{};

    explicit State(IiodDescription description) : shared{.device = IiodDevice{std::move(description)}} {}
    State(const State&) = delete;
    State& operator=(const State&) = delete;
    ~State() {
        io.stop();
        if (thread.joinable()) thread.join();
    }
    void listen(std::uint16_t wanted);
    void accept();
    void distribute(const std::vector<IiodSample>& samples);
    void distribute(IiodSample sample);
};

void Iiod::State::listen(std::uint16_t wanted) {
    try {
        const tcp::endpoint endpoint{asio::ip::address_v4::loopback(), wanted};
        acceptor.open(endpoint.protocol());
        acceptor.set_option(tcp::acceptor::reuse_address{true});
        acceptor.bind(endpoint);
        acceptor.listen();
        port = acceptor.local_endpoint().port();
    } catch (const boost::system::system_error& e) {
        throw DeviceError{"mock iiod: port " + std::to_string(wanted) + ": " + e.code().message()};
    }
    accept();
}

void Iiod::State::accept() {
    acceptor.async_accept([this](error_code error, tcp::socket socket) {
        std::erase_if(connections, [](const auto& c) { return c->closed(); });
        if (!error) {
            connections.push_back(std::make_shared<IiodConnection>(std::move(socket), shared));
            connections.back()->start();
            ++accepted;
        }
        accept();
    });
}

void Iiod::State::distribute(const std::vector<IiodSample>& samples) {
    for (const IiodSample& sample : samples) distribute(sample);
    for (const auto& connection : connections) connection->serve();
    under_way -= samples.size();
    pushed += samples.size();
}

void Iiod::State::distribute(IiodSample sample) {
    if (to_drop > 0) {
        --to_drop;
        ++dropped;
        return;
    }
    if (to_freeze > 0) {
        --to_freeze;
        sample.counts = last_counts;
    }
    last_counts = sample.counts;
    sample.stamp_ns = late.stamp(sample.stamp_ns) + shift_ns;
    bool heard = false;
    for (const auto& connection : connections) {
        if (!connection->buffer_open()) continue;
        connection->offer(sample);
        heard = true;
    }
    if (!heard) ++unheard;
}

Iiod::Iiod(IiodDescription description, std::uint16_t port)
    : state_{std::make_unique<State>(std::move(description))} {
    state_->listen(port);
    state_->thread = std::jthread{[s = state_.get()] {
        static_cast<void>(name_thread("mock iiod"));
        s->io.run();
    }};
}

Iiod::~Iiod() = default;

std::uint16_t Iiod::port() const noexcept { return state_->port; }
double Iiod::rate_hz() const noexcept { return state_->shared.rate_hz; }

IiodCounts Iiod::counts() const noexcept {
    const State& s = *state_;
    return {s.pushed,        s.dropped, s.unheard, s.shared.served, s.shared.overflowed,
            s.shared.unread, s.accepted};
}

void Iiod::push(std::span<const IiodSample> samples) {
    State& s = *state_;
    if (s.under_way + samples.size() > most_under_way) {
        s.pushed += samples.size();
        s.shared.overflowed += samples.size();
        return;
    }
    s.under_way += samples.size();
    asio::post(s.io, [&s, copy = std::vector(samples.begin(), samples.end())] { s.distribute(copy); });
}

void Iiod::silence(double seconds) {
    asio::post(state_->io, [&s = *state_, seconds] {
        s.shared.silent = true;
        s.silence_over.expires_after(std::chrono::nanoseconds{std::llround(1e9 * seconds)});
        s.silence_over.async_wait([&s](error_code error) {
            if (error) return;
            s.shared.silent = false;
            for (const auto& connection : s.connections) connection->flush();
        });
    });
}

void Iiod::freeze(double seconds) {
    asio::post(state_->io, [&s = *state_, seconds] {
        s.to_freeze = static_cast<std::uint64_t>(std::llround(seconds * s.shared.device.rate_hz()));
    });
}

void Iiod::drop(std::uint64_t samples) {
    asio::post(state_->io, [&s = *state_, samples] { s.to_drop += samples; });
}

void Iiod::disconnect() {
    asio::post(state_->io, [&s = *state_] {
        for (const auto& connection : s.connections) connection->close();
        s.connections.clear();
    });
}

void Iiod::error(int error) {
    asio::post(state_->io, [&s = *state_, error] {
        for (const auto& connection : s.connections) connection->fail(error);
    });
}

void Iiod::shift_stamps(std::int64_t ns) {
    asio::post(state_->io, [&s = *state_, ns] { s.shift_ns += ns; });
}

void Iiod::jitter_stamps(std::int64_t ns) {
    asio::post(state_->io, [&s = *state_, ns] { s.late.set(ns); });
}

}  // namespace shaker::mock
