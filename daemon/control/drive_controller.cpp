#include "daemon/control/drive_controller.hpp"

#include <algorithm>
#include <cmath>

#include "daemon/control/mains.hpp"

namespace shaker::control {

namespace {

// The same motion the other way round, half a period later: what a plant without preferred direction makes of
// the mirrored drive.
template <class Unit>
Harmonics<Unit> mirrored(Harmonics<Unit> h) {
    for (int q = 2; q <= max_harmonics; q += 2) h.at(q) = -h.at(q);
    return h;
}

bool equal(const Harmonics<Acceleration>& a, const Harmonics<Acceleration>& b) {
    constexpr double rounding = 1e-9;  // of the largest amplitude
    double apart = 0, most = 0;
    for (int q = 1; q <= max_harmonics; ++q) {
        apart = std::max(apart, std::abs(a.at(q) - b.at(q)));
        most = std::max(most, std::abs(a.at(q)));
    }
    return apart <= rounding * most;
}

}  // namespace

DriveController::DriveController(const ControllerSettings& settings) : settings_{settings} {}

void DriveController::quiet(const PeriodEstimate& window) {
    ++quiet_windows_;
    noise_ += (window.sd - noise_) / quiet_windows_;
}

void DriveController::limit(double volts) noexcept {
    settings_.volts_limit = volts;
    if (equaliser_) equaliser_->limit(volts);
}

bool DriveController::begin_identification() {
    if (!settings_.identify || !settings_.equalise) return false;
    IdentificationSettings s{.harmonics = controlled_harmonics,
                             .gamma = settings_.drive.gamma,
                             .volts_limit = settings_.volts_limit,
                             .nominal = response_at(settings_.drive.frequency)};
    identification_ = std::make_unique<Identification>(s);
    volts_ = identification_->volts();
    return true;
}

std::vector<int> DriveController::hidden(double frequency) const {
    return hidden_harmonics(lines_hz_, frequency, controlled_harmonics);
}

EqualiserSettings DriveController::equaliser_settings(bool from_below) const {
    return {.harmonics = controlled_harmonics,
            .volts_limit = settings_.volts_limit,
            .noise = noise_,
            .from_below = from_below,
            .hidden = hidden(settings_.drive.frequency)};
}

void DriveController::begin() {
    identification_.reset();
    equaliser_ =
        std::make_unique<Equaliser>(harmonics(settings_.drive), response_at(settings_.drive.frequency),
                                    equaliser_settings(settings_.equalise));
    volts_ = equaliser_->volts();
    known_.clear();
}

// The identified response corrects the data sheet by the ratio of both, which is known at the harmonics of
// one frequency and interpolated linearly between them.
std::array<std::complex<double>, max_harmonics> DriveController::response_at(double frequency) const {
    std::array<std::complex<double>, max_harmonics> h{};
    for (int q = 1; q <= max_harmonics; ++q) {
        const double hz = q * frequency;
        std::complex<double> ratio = 1;
        if (identified_) {
            const double place = std::clamp(hz / identified_->frequency, 1.0, 1.0 * identified_->harmonics);
            const int below = std::min(static_cast<int>(place), identified_->harmonics - 1);
            const auto at = [&](int k) {
                return identified_->h[static_cast<std::size_t>(k - 1)] /
                       settings_.sheet(k * identified_->frequency);
            };
            ratio = at(below) + (place - below) * (at(below + 1) - at(below));
        }
        h[static_cast<std::size_t>(q - 1)] = ratio * settings_.sheet(hz);
    }
    return h;
}

DriveController::Outcome DriveController::take(const PeriodWindows::Window& window, bool newest) {
    if (identification_) {
        if (!window.motion.steady || !newest || !identification_->take(window.estimate))
            return Outcome::nothing;
        if (!identification_->done()) {
            volts_ = identification_->volts();
            return Outcome::step;
        }
        identified_ = identification_->response();
        identified_->frequency = settings_.drive.frequency;
        return Outcome::identified;
    }
    if (!equaliser_ || !settings_.equalise) return Outcome::nothing;
    PeriodWindow motion = window.motion;
    motion.steady = motion.steady && newest;
    report_ = equaliser_->take(motion);
    if (equaliser_->volts() == volts_) return Outcome::nothing;
    volts_ = equaliser_->volts();
    return report_.mode == Equaliser::Mode::track ? Outcome::correction : Outcome::step;
}

void DriveController::remember(const Known& locked) {
    constexpr std::size_t most = 64;
    std::erase_if(known_, [&](const Known& k) { return equal(k.target, locked.target); });
    if (known_.size() == most) known_.erase(known_.begin());
    known_.push_back(locked);
}

const Harmonics<Voltage>* DriveController::known_drive(const Harmonics<Acceleration>& target) const {
    const auto known = std::ranges::find_if(known_, [&](const Known& k) { return equal(k.target, target); });
    return known == known_.end() ? nullptr : &known->volts;
}

void DriveController::set(const Drive& drive) {
    const bool same_frequency = drive.frequency == settings_.drive.frequency, locked = report_.locked;
    const Harmonics<Acceleration> left = harmonics(settings_.drive);
    settings_.drive = drive;
    const Harmonics<Acceleration> target = harmonics(drive);
    if (same_frequency) {
        if (locked) {
            remember({left, volts_});
            const Known partner{mirrored(left), mirrored(volts_)};
            if (known_drive(partner.target) == nullptr) remember(partner);
        }
        equaliser_->retarget(target, known_drive(target));
    } else {
        known_.clear();
        equaliser_ = std::make_unique<Equaliser>(harmonics(drive), response_at(drive.frequency),
                                                 equaliser_settings(false));
    }
    volts_ = equaliser_->volts();
    report_ = {};
}

}  // namespace shaker::control
