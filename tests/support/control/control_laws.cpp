// Our law and the two usual ones, behind one interface.
#include "tests/support/control/control_bench.hpp"

namespace shaker::test {

namespace {

class Hybrid final : public DriveLaw {
public:
    explicit Hybrid(const Known& known)
        : controller_{{.drive = known.drive, .volts_limit = known.volts_limit, .sheet = known.sheet}} {
        control::PeriodEstimate quiet;
        quiet.sd = known.noise;
        controller_.quiet(quiet);
        controller_.adopt(known.response);
        controller_.begin();
    }
    const Harmonics<Voltage>& volts() override { return controller_.volts(); }
    bool take(const control::PeriodWindows::Window& window, bool newest) override {
        return controller_.take(window, newest) != control::DriveController::Outcome::nothing;
    }
    void set(const Drive& drive) override { controller_.set(drive); }
    bool gave_up() override { return controller_.report().mode == control::Equaliser::Mode::failed; }
    double reached() override { return controller_.report().reached; }

private:
    control::DriveController controller_;
};

/// The usual laws: correct a share of the error in each window, or each time the motion has settled.
class Integral final : public DriveLaw {
public:
    Integral(const Known& known, double share, bool settled_only)
        : known_{known}, share_{share}, settled_{settled_only} {
        set(known.drive);
        volts_ = {};
        step(harmonics(known.drive), 1);
    }
    const Harmonics<Voltage>& volts() override { return volts_; }
    bool take(const control::PeriodWindows::Window& window, bool newest) override {
        if (gave_up_) return false;
        const Harmonics<Acceleration> target = harmonics(known_.drive), &got = window.motion.measured;
        if (settled_) {
            if (!window.motion.steady || !newest) return false;
            double moved = 0;
            for (int q = 1; q <= control::controlled_harmonics; ++q)
                moved += std::norm(got.at(q) - before_.at(q));
            before_ = got;
            // Until two windows agree within the noise, or a thousandth of the target.
            const double still =
                std::max(8 * known_.noise, 1e-3 * control::norm(target, control::controlled_harmonics));
            ++waited_;
            if ((waited_ < 2 || std::sqrt(moved) > still) && waited_ < 40) return false;
            waited_ = 0;
        }
        Harmonics<Acceleration> error;
        for (int q = 1; q <= control::controlled_harmonics; ++q) error.at(q) = target.at(q) - got.at(q);
        step(error, share_);
        gave_up_ = !(control::peak(volts_) < 10 * known_.volts_limit);
        if (gave_up_) volts_ = {};
        return true;
    }
    void set(const Drive& drive) override {
        if (drive.frequency != known_.drive.frequency) {
            for (int q = 1; q <= control::controlled_harmonics; ++q)
                known_.response.h[static_cast<std::size_t>(q - 1)] = known_.sheet(q * drive.frequency);
            volts_ = {};
            step(harmonics(drive), 1);
        } else {
            Harmonics<Acceleration> change = harmonics(drive);
            const Harmonics<Acceleration> before = harmonics(known_.drive);
            for (int q = 1; q <= 2; ++q) change.at(q) -= before.at(q);
            step(change, 1);
        }
        known_.drive = drive;
    }
    bool gave_up() override { return gave_up_; }

private:
    void step(const Harmonics<Acceleration>& by, double share) {
        for (int q = 1; q <= control::controlled_harmonics; ++q)
            volts_.at(q) += share * by.at(q) / known_.response.h[static_cast<std::size_t>(q - 1)];
    }
    Known known_;
    double share_;
    bool settled_, gave_up_ = false;
    int waited_ = 0;
    Harmonics<Acceleration> before_;
    Harmonics<Voltage> volts_;
};

}  // namespace

MakeLaw hybrid() {
    return [](const Known& known) { return std::make_unique<Hybrid>(known); };
}
MakeLaw integral(double share) {
    return [share](const Known& known) { return std::make_unique<Integral>(known, share, false); };
}
MakeLaw time_waveform(double share) {
    return [share](const Known& known) { return std::make_unique<Integral>(known, share, true); };
}

}  // namespace shaker::test
