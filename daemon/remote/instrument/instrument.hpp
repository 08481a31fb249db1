#pragma once
// BenchInstrument: the bench as an SCPI instrument.
#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "daemon/remote/access/access.hpp"
#include "daemon/remote/scpi/command.hpp"
#include "daemon/remote/scpi/reply.hpp"
#include "daemon/remote/scpi/session.hpp"
#include "daemon/remote/scpi/status_model.hpp"
#include "daemon/service/pending_orders.hpp"

namespace shaker::instrument {

class BenchInstrument final : public scpi::Instrument {
public:
    using Refused = std::function<void(const std::string& session, const std::string& why)>;
    /// refused: called when an order of the session of that name is refused; the session may have ended.
    BenchInstrument(service::PendingOrders& pending_orders, access::Aborts& aborts, Refused refused)
        : pending_orders_{pending_orders}, aborts_{aborts}, refused_{std::move(refused)} {}

    [[nodiscard]] std::string identity() const override;
    [[nodiscard]] std::string options() const override;
    void reset(const scpi::Session& by) override;
    int self_test() override;
    void trigger(const scpi::Session& by) override;
    void save(int place) override;
    void recall(const scpi::Session& by, int place) override;
    access::Aborts::Receipt abort(const scpi::Session& by) override;
    [[nodiscard]] bool pending() const override { return pending_orders_.pending(); }

    /// Posts an order of a session; a refusal becomes its error -221.
    void order(const scpi::Session& session, service::OrderWhat what);
    [[nodiscard]] service::PendingOrders& pending_orders() noexcept { return pending_orders_; }
    /// The present state; Error -230 before there is one.
    [[nodiscard]] std::shared_ptr<const service::BenchState> state() const;
    /// Parameters of a measurement that a client set, as in measurement_fields.
    std::array<std::optional<int>, measurement_fields.size()> given{};
    /// The order that starts a run with them, else with the bench's own.
    [[nodiscard]] service::Begin next() const;
    bool on_trigger = false;  // INITiate waits for *TRG
    bool armed = false;       // INITiate was sent and *TRG is awaited
    /// Address of the live streams: "ws://127.0.0.1:8080/ws".
    std::string streams{};

private:
    service::PendingOrders& pending_orders_;
    access::Aborts& aborts_;
    Refused refused_;
    std::array<std::optional<Drive>, 10> saved_{};
};

/// Sets the condition registers from a state.
void show(const service::BenchState& state, scpi::DeviceStatus& status);

/// The command of an order, made from its row; its parameters are the fields of the row, the first
/// of which is needed.
scpi::Command command_of(BenchInstrument& bench, std::string_view order, scpi::Handler query = {},
                         scpi::Placeholder without = scpi::nans<1>);

/// Replies the value that `of` returns: a bool, a number, or a text in quotes.
template <class Of>
scpi::Handler one(Of of) {
    return [of](scpi::Call& call) {
        if constexpr (std::is_same_v<decltype(of()), bool>)
            call.reply.boolean(of());
        else if constexpr (std::is_same_v<decltype(of()), double>)
            call.reply.number(of());
        else
            call.reply.string(of());
    };
}

/// A query of one value of the present state.
template <class Of>
scpi::Command asks(BenchInstrument& bench, std::string header, Of of) {
    using Value = decltype(of(*bench.state()));
    return {.header = std::move(header),
            .query = one([&bench, of] { return of(*bench.state()); }),
            .without = std::is_arithmetic_v<Value> ? scpi::nans<1> : scpi::empty_string};
}

// Its commands, one function per part of the SCPI tree.

/// SOURce: requested motion of the base, and the predicted demands of that motion.
std::vector<scpi::Command> source_commands(BenchInstrument& bench);
/// OUTPut: drive on and off, protection.
std::vector<scpi::Command> output_commands(BenchInstrument& bench);
/// CONTrol: identification and the loop; FETCh:ACCeleration:HARMonics?.
std::vector<scpi::Command> control_commands(BenchInstrument& bench);
/// SOURce: FUNCtion and HARMonic, the shape of one period.
std::vector<scpi::Command> shape_commands(BenchInstrument& bench);
/// INITiate, TRIGger, AVERage, READ, MEASure: start of a measurement, and its parameters.
std::vector<scpi::Command> read_commands(BenchInstrument& bench);
/// CAMPaign: the points of a plan.
std::vector<scpi::Command> campaign_commands(BenchInstrument& bench);
/// FETCh: results of the newest measurement.
std::vector<scpi::Command> fetch_commands(BenchInstrument& bench);
/// RECord: recording of the following runs.
std::vector<scpi::Command> record_commands(BenchInstrument& bench);
/// SENSe: state of the sensors; STReam: address of the live streams.
std::vector<scpi::Command> sense_commands(BenchInstrument& bench);
/// Queries of one published quantity each.
std::vector<scpi::Command> published_commands(BenchInstrument& bench);
/// LIMit, SYSTem, DIAGnostic.
std::vector<scpi::Command> bench_commands(BenchInstrument& bench);

/// All of them, after the standard commands.
std::vector<scpi::Command> command_table(BenchInstrument& bench);

/// The newest result, for FETCh:DRIFt? and READ?; error -230 without a result.
std::shared_ptr<const reduction::Reduction> result_of(const service::BenchState& state);
void reply_drift(const service::BenchState& state, scpi::Reply& reply);
/// The same without a result: NaN, NaN, NaN, 0 periods, not measuring.
void reply_no_drift(scpi::Reply& reply);

}  // namespace shaker::instrument
