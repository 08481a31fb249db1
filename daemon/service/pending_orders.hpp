#pragma once
// Orders of clients: in words, and the state that the bench will have after all that are under way.
#include <functional>
#include <memory>
#include <string>

#include "daemon/service/bench_port.hpp"

namespace shaker::service {

/// A recording's name: 1 to 64 letters, digits, dots, hyphens and underscores, no dot in front. InputError
/// with the name otherwise.
void require_name(const std::string& what, const std::string& name);
/// A remark: 1 to 400 bytes of UTF-8 without control characters. InputError otherwise.
void require_remark(const std::string& text);

/// An order in words for the log: "set-point 20 Hz, gamma 1.5 g, rho 0.5, phi 35 deg". kind: "order" switches
/// the drive, "setting" does not. Orders of one kind and key are alike. An empty text is not logged: the
/// bench logs it itself.
struct OrderText {
    const char* kind = "order";
    std::string key{};
    std::string text = key;
};
OrderText words_of(const OrderWhat& what);

/// The state that the bench will have after all orders under way. Used on the thread that serves the clients.
class PendingOrders {
public:
    /// later: passes a function from any thread to this one. Copies of `later` outlive this object; after its
    /// end they must drop the function.
    using Later = std::function<void(std::function<void()>)>;
    PendingOrders(BenchPort& bench_port, Later later) : bench_port_{bench_port}, later_{std::move(later)} {}

    /// The newest published state; null before the first.
    [[nodiscard]] std::shared_ptr<const BenchState> now() const { return bench_port_.state(); }
    /// Settings that orders change, with the values after all orders under way. A client that sets and then
    /// reads gets what it set.
    struct Settings {
        Drive drive{};
        safety::Limits limits{};
        Record record{};
        Begin run{};
        bool closed_loop = false;
    };
    [[nodiscard]] Settings settings() const;
    [[nodiscard]] Drive drive() const { return settings().drive; }
    [[nodiscard]] safety::Limits limits() const { return settings().limits; }
    /// True while an order or an abort is under way, or an operation that it started: a ramp, an
    /// identification, a stop.
    [[nodiscard]] bool pending() const;

    /// Gives an order of the client `by`; the log names the client and the order. answered(refused)
    /// is called once on this thread; refused: the reason, empty: carried out.
    using Answered = std::function<void(const std::string& refused)>;
    void order(OrderWhat what, const std::string& by, Answered answered);
    [[nodiscard]] BenchPort& bench_port() noexcept { return bench_port_; }

private:
    void log(const OrderText& words, const std::string& by);

    BenchPort& bench_port_;
    Later later_;
    std::size_t under_way_ = 0;  // orders without an answer
    Settings ordered_;           // while orders are under way
};

}  // namespace shaker::service
