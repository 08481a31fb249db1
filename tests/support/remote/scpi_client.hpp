#pragma once
// A bench that only stores the commands it receives, and a client.
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/remote/scpi/session.hpp"

namespace shaker::test {

class FakeInstrument final : public scpi::Instrument {
public:
    [[nodiscard]] std::string identity() const override { return "maker,model,1,0.1"; }
    [[nodiscard]] std::string options() const override { return "0"; }
    void reset(const scpi::Session& /*by*/) override { told.emplace_back("reset"); }
    int self_test() override { return 0; }
    void trigger(const scpi::Session& /*by*/) override { told.emplace_back("trigger"); }
    void save(int place) override { told.push_back("save " + std::to_string(place)); }
    void recall(const scpi::Session& /*by*/, int place) override {
        told.push_back("recall " + std::to_string(place));
    }
    access::Aborts::Receipt abort(const scpi::Session& /*by*/) override {
        told.emplace_back("abort");
        busy = busy && !abort_ends_it;
        return [this] { return abort_answer; };
    }
    [[nodiscard]] bool pending() const override { return busy; }

    bool busy = false;
    bool abort_ends_it = true;
    access::Aborts::Answer abort_answer = access::Aborts::Answer::obeyed;
    std::vector<std::string> told;  // in order
};

/// One instrument for any number of clients.
struct ScpiBench {
    FakeInstrument instrument;
    double frequency = 20, acceleration = 9.8;
    std::array<double, 16> amplitudes{};
    std::string note;
    std::string wave;
    scpi::DeviceStatus status;
    access::ControlLock lock;
    access::Access access;
    scpi::CommandTree tree;

    ScpiBench();
    [[nodiscard]] scpi::Shared shared() { return {tree, instrument, status, lock, access}; }
    [[nodiscard]] std::string last_told() const {
        return instrument.told.empty() ? "" : instrument.told.back();
    }
};

class ScpiClient {
public:
    explicit ScpiClient(ScpiBench& bench, std::string name = "192.0.2.1:5",
                        scpi::Admission admission = scpi::Admission::free)
        : session{bench.shared(), std::move(name), admission} {}

    /// Sends the text and a line feed; returns the output available then.
    std::string ask(std::string_view message) {
        session.feed(message);
        session.feed("\n");
        return read();
    }
    /// All available output.
    std::string read();
    /// The answer to SYSTem:ERRor?, without the line feed.
    std::string error() {
        std::string line = ask("SYST:ERR?");
        if (!line.empty()) line.pop_back();
        return line;
    }

    scpi::Session session;
};

}  // namespace shaker::test
