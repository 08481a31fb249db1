// Our law and the two usual ones, behind the bench's interface.
#include "tests/support/control_bench.hpp"

namespace shaker::test {

namespace {

class Hybrid final : public DriveLaw {
public:
    explicit Hybrid(const Known& known)
        : keeper_{{.drive = known.drive, .volts_limit = known.volts_limit, .sheet = known.sheet}} {
        PeriodEstimate quiet;
        quiet.sd = known.noise;
        keeper_.quiet(quiet);
        keeper_.adopt(known.response);
        keeper_.begin();
    }
    const Harmonics<Voltage>& volts() override { return keeper_.volts(); }
    bool take(const MotionWindows::Window& window, bool newest) override {
        return keeper_.take(window, newest) != DriveKeeper::Outcome::nothing;
    }
    void set(const Drive& drive) override { keeper_.set(drive); }
    bool gave_up() override { return keeper_.report().mode == Equaliser::Mode::failed; }
    double reached() override { return keeper_.report().reached; }

private:
    DriveKeeper keeper_;
};

/// The usual ones: a share of the error each window, or each time the motion has settled.
class Integral final : public DriveLaw {
public:
    Integral(const Known& known, double share, bool settled_only)
        : known_{known}, share_{share}, settled_{settled_only} {
        set(known.drive);
        volts_ = {};
        step(harmonics(known.drive), 1);
    }
    const Harmonics<Voltage>& volts() override { return volts_; }
    bool take(const MotionWindows::Window& window, bool newest) override {
        if (gave_up_) return false;
        const Harmonics<Acceleration> target = harmonics(known_.drive), &got = window.motion.measured;
        if (settled_) {
            if (!window.motion.steady || !newest) return false;
            double moved = 0;
            for (int q = 1; q <= controlled_harmonics; ++q) moved += std::norm(got.at(q) - before_.at(q));
            before_ = got;
            // Until two windows agree within the noise, or a thousandth of the target.
            const double still = std::max(8 * known_.noise, 1e-3 * norm(target, controlled_harmonics));
            ++waited_;
            if ((waited_ < 2 || std::sqrt(moved) > still) && waited_ < 40) return false;
            waited_ = 0;
        }
        Harmonics<Acceleration> error;
        for (int q = 1; q <= controlled_harmonics; ++q) error.at(q) = target.at(q) - got.at(q);
        step(error, share_);
        gave_up_ = !(peak(volts_) < 10 * known_.volts_limit);
        if (gave_up_) volts_ = {};
        return true;
    }
    void set(const Drive& drive) override {
        if (drive.frequency != known_.drive.frequency) {
            for (int q = 1; q <= controlled_harmonics; ++q)
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
        for (int q = 1; q <= controlled_harmonics; ++q)
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
