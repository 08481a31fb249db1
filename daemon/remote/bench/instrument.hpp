#pragma once
// The bench as the instrument language sees it.
#include <array>
#include <functional>
#include <optional>
#include <string>

#include "daemon/order_book.hpp"
#include "daemon/remote/scpi/device_status.hpp"
#include "daemon/remote/scpi/instrument.hpp"

namespace shaker {

class BenchInstrument final : public scpi::Instrument {
public:
    using Aborted = std::function<void(const scpi::Session& by)>;
    using Refused = std::function<void(const std::string& session, const std::string& why)>;
    /// aborted: all sessions but the one that asked are to forget what they withhold. refused: an order of
    /// the session of that name, which may be gone.
    BenchInstrument(OrderBook& book, Aborted aborted, Refused refused)
        : book_{book}, aborted_{std::move(aborted)}, refused_{std::move(refused)} {}

    [[nodiscard]] std::string identity() const override;
    [[nodiscard]] std::string options() const override;
    void reset() override;
    int self_test() override;
    void trigger() override;
    void save(int place) override;
    void recall(int place) override;
    void abort(const scpi::Session& by) override;
    [[nodiscard]] bool pending() const override { return book_.pending(); }

    /// Orders for a session; a refusal becomes its -221.
    void order(const scpi::Session& session, OrderWhat what);
    [[nodiscard]] OrderBook& book() noexcept { return book_; }
    /// The state; Error -230 before there is one.
    [[nodiscard]] std::shared_ptr<const BenchState> state() const;
    /// Of AVERage; none: as the bench has them.
    std::optional<int> periods{}, settle{};
    /// What begins a run with them.
    [[nodiscard]] Begin next() const;
    bool on_trigger = false;  // INITiate waits for *TRG
    bool armed = false;       // it does
    /// Address of the live streams: "ws://127.0.0.1:8080/ws".
    std::string streams{};

private:
    OrderBook& book_;
    Aborted aborted_;
    Refused refused_;
    std::array<std::optional<Drive>, 10> saved_{};
};

/// Sets the condition registers by a state.
void show(const BenchState& state, scpi::DeviceStatus& status);

}  // namespace shaker
