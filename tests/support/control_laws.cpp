// Our law and the two usual ones, behind the bench's interface.
#include "tests/support/control_bench.hpp"

namespace shaker::test {

namespace {

class Hybrid final : public DriveLaw {
public:
    Hybrid(const Harmonics<Acceleration>& target,
           const std::array<std::complex<double>, max_harmonics>& response, const EqualiserSettings& settings)
        : equaliser_{target, response, settings} {}
    const Harmonics<Voltage>& volts() override { return equaliser_.volts(); }
    bool take(const MotionWindow& window) override {
        const Harmonics<Voltage> before = equaliser_.volts();
        report_ = equaliser_.take(window);
        return equaliser_.volts() != before;
    }
    void retarget(const Harmonics<Acceleration>& target) override { equaliser_.retarget(target); }
    bool gave_up() override { return report_.mode == Equaliser::Mode::failed; }
    double reached() override { return report_.reached; }

private:
    Equaliser equaliser_;
    Equaliser::Report report_;
};

class Integral final : public DriveLaw {
public:
    Integral(const Harmonics<Acceleration>& target,
             const std::array<std::complex<double>, max_harmonics>& response,
             const EqualiserSettings& settings, double share, bool settled_only)
        : target_{target}, response_{response}, settings_{settings}, share_{share}, settled_{settled_only} {
        for (int q = 1; q <= settings_.harmonics; ++q)
            volts_.at(q) = target_.at(q) / response_[static_cast<std::size_t>(q - 1)];
    }
    const Harmonics<Voltage>& volts() override { return volts_; }
    bool take(const MotionWindow& window) override {
        if (gave_up_) return false;
        if (settled_) {
            if (!window.steady) return false;
            ++waited_;
            double moved = 0;
            for (int q = 1; q <= settings_.harmonics; ++q)
                moved += std::norm(window.measured.at(q) - before_.at(q));
            before_ = window.measured;
            // Until two windows agree within the noise, or a thousandth of the target.
            const double still = std::max(8 * settings_.noise, 1e-3 * norm(target_, settings_.harmonics));
            if ((waited_ < 2 || std::sqrt(moved) > still) && waited_ < 40) return false;
            waited_ = 0;
        }
        for (int q = 1; q <= settings_.harmonics; ++q)
            volts_.at(q) +=
                share_ * (target_.at(q) - window.measured.at(q)) / response_[static_cast<std::size_t>(q - 1)];
        gave_up_ = !(peak(volts_) < 10 * settings_.volts_limit);
        if (gave_up_) volts_ = {};
        return true;
    }
    void retarget(const Harmonics<Acceleration>& target) override {
        for (int q = 1; q <= settings_.harmonics; ++q)
            volts_.at(q) += (target.at(q) - target_.at(q)) / response_[static_cast<std::size_t>(q - 1)];
        target_ = target;
    }
    bool gave_up() override { return gave_up_; }

private:
    Harmonics<Acceleration> target_;
    std::array<std::complex<double>, max_harmonics> response_;
    EqualiserSettings settings_;
    double share_;
    bool settled_, gave_up_ = false;
    int waited_ = 0;
    Harmonics<Acceleration> before_;
    Harmonics<Voltage> volts_;
};

}  // namespace

MakeLaw hybrid() {
    return [](const auto& target, const auto& response, const auto& settings) {
        return std::make_unique<Hybrid>(target, response, settings);
    };
}
MakeLaw integral(double share) {
    return [share](const auto& target, const auto& response, const auto& settings) {
        return std::make_unique<Integral>(target, response, settings, share, false);
    };
}
MakeLaw time_waveform(double share) {
    return [share](const auto& target, const auto& response, const auto& settings) {
        return std::make_unique<Integral>(target, response, settings, share, true);
    };
}

}  // namespace shaker::test
