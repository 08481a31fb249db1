#include "drivers/recorded/played_drive.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "drivers/errors.hpp"

namespace shaker::recorded {

namespace {

bool is_silence(const DriveChange& change) { return change.ramp == 0 && change.stop == 0; }

double rate_of(const DacInfo& dac) {
    if (!(dac.rate_hz > 0)) throw InputError{"recording: it has no drive, because it was made without a DAC"};
    return dac.rate_hz;
}

// Largest plausible number of samples in a file: 3 years at 48 kHz.
constexpr std::int64_t longest = std::int64_t{1} << 42;

std::int64_t in_range(std::int64_t samples, const char* path) {
    if (samples < 0 || samples > longest)
        throw InputError{std::string{"recording: raw/drive/"} + path + " " + std::to_string(samples) +
                         " is not in 0.." + std::to_string(longest)};
    return samples;
}

}  // namespace

PlayedDrive::PlayedDrive(const DacInfo& dac, double frequency_hz, std::vector<DriveChange> changes,
                         const std::vector<PlayTime>& played)
    : synthesiser_{rate_of(dac), frequency_hz, dac.full_scale_V}, changes_{in_effect(std::move(changes))} {
    for (const DriveChange& c : changes_) {
        in_range(c.first.n, "changes/first_tick");
        in_range(c.stop, "changes/stop_samples");
    }
    for (const PlayTime& p : played)
        if (in_range(p.lost, "play_lost") > 0) lost_.push_back(p.lost);
}

void PlayedDrive::require_made(const DriveChange& c) const {
    const DriveChange* made = synthesiser_.change();
    if (made != nullptr && made->first == c.first && made->ramp == c.ramp && made->stop == c.stop &&
        made->phase == c.phase && made->step == c.step && made->command.volts == c.command.volts)
        return;
    throw InputError{"recording: raw/drive/changes row " + std::to_string(next_ - 1) +
                     " does not follow from the rows before it"};
}

void PlayedDrive::apply(const DriveChange& change, std::int64_t lost) {
    ++next_;
    synthesiser_.release();  // not recorded in any row: a change after the end of a stop implies it
    if (is_silence(change)) {
        if (lost == 0)
            throw InputError{"recording: raw/drive/changes row " + std::to_string(next_ - 1) +
                             " is a silence that raw/drive/play_lost does not record"};
        ++next_lost_;
        silent_ = lost;
        synthesiser_.silence(lost);
    } else if (change.stop > 0) {
        synthesiser_.stop(change.stop, change.ramp == 0);
    } else {
        synthesiser_.set(change.command);
        due_ = true;
        return;
    }
    require_made(change);
}

void PlayedDrive::fill(std::span<double> volts) {
    while (!volts.empty()) {
        auto n = static_cast<std::int64_t>(volts.size());
        if (silent_ > 0) {
            n = std::min(n, silent_);
            std::ranges::fill(volts.first(static_cast<std::size_t>(n)), 0);
            silent_ -= n;
            volts = volts.subspan(static_cast<std::size_t>(n));
            continue;
        }
        if (next_ < changes_.size()) {
            const DriveChange& change = changes_[next_];
            const std::int64_t lost = is_silence(change) && next_lost_ < lost_.size() ? lost_[next_lost_] : 0;
            const std::int64_t wait = change.first.n - lost - synthesiser_.tick().n;
            if (wait <= 0 && !due_) {
                apply(change, lost);
                continue;
            }
            n = std::min(n, std::max<std::int64_t>(wait, 1));
        }
        synthesiser_.fill(volts.first(static_cast<std::size_t>(n)));
        if (std::exchange(due_, false)) require_made(changes_[next_ - 1]);
        volts = volts.subspan(static_cast<std::size_t>(n));
    }
}

}  // namespace shaker::recorded
