#include "daemon/control/mains.hpp"

#include <algorithm>
#include <cmath>

#include "daemon/control/harmonic_estimator.hpp"
#include "drivers/drive.hpp"

namespace shaker::control {

namespace {

constexpr double block_s = 0.2, neighbour_hz = 5;
constexpr std::array nominal_hz{50.0, 60.0};
constexpr double off_nominal = 0.01;
constexpr double clear_of_neighbours = 30;
constexpr double least_mps2 = 1e-3;
constexpr int least_blocks = 3, longest_watch = 50;
constexpr double highest = 0.45, whole_block = 0.95;

}  // namespace

int Mains::strongest() const noexcept {
    return static_cast<int>(std::ranges::max_element(amplitude) - amplitude.begin()) + 1;
}

MainsWatch::MainsWatch(double rate_hz) : rate_hz_{rate_hz} {
    for (const double nominal : nominal_hz)
        for (int m = 1; m <= Mains::multiples; ++m)
            for (const double hz : {m * nominal - neighbour_hz, m * nominal, m * nominal + neighbour_hz})
                if (hz < highest * rate_hz && at(hz) == nullptr) bins_.emplace_back().hz = hz;
}

const MainsWatch::Bin* MainsWatch::at(double hz) const noexcept {
    const auto bin = std::ranges::find(bins_, hz, &Bin::hz);
    return bin == bins_.end() ? nullptr : &*bin;
}

void MainsWatch::add(double at_s, const std::array<double, 3>& a) {
    if (blocks_ >= longest_watch || bins_.empty()) return;
    if (block_ < 0) rest_ = a, from_s_ = at_s;
    const double block = std::floor((at_s - from_s_) / block_s);
    if (block != block_) {
        finish();
        follows_ = follows_ && block == block_ + 1;
        block_ = block;
    }
    ++samples_;
    for (Bin& bin : bins_) {
        const std::complex<double> z = std::polar(1.0, -two_pi * std::fmod(bin.hz * at_s, 1.0));
        for (std::size_t k = 0; k < 3; ++k) bin.now[k] += (a[k] - rest_[k]) * z;
    }
}

// A block that is not whole is left out.
void MainsWatch::finish() {
    const bool whole = samples_ >= whole_block * block_s * rate_hz_;
    for (Bin& bin : bins_) {
        if (whole) {
            for (std::size_t k = 0; k < 3; ++k) {
                const std::complex<double> z = 2.0 / samples_ * bin.now[k];
                bin.power += std::norm(z);
                if (follows_) bin.turn += z * std::conj(bin.before[k]);
                bin.before[k] = z;
            }
        }
        bin.now = {};
    }
    blocks_ += whole;
    follows_ = whole;
    samples_ = 0;
}

std::optional<Mains> MainsWatch::found() const {
    std::optional<Mains> best;
    if (blocks_ < least_blocks) return best;
    for (const double nominal : nominal_hz) {
        Mains mains;
        double strongest = 0;
        for (int m = 1; m <= Mains::multiples; ++m) {
            const Bin *const line = at(m * nominal), *const below = at(m * nominal - neighbour_hz),
                             *const above = at(m * nominal + neighbour_hz);
            if (line == nullptr || below == nullptr || above == nullptr) continue;
            const double power = line->power / blocks_, noise = (below->power + above->power) / 2 / blocks_;
            if (power < clear_of_neighbours * noise + least_mps2 * least_mps2) continue;
            mains.amplitude.at(static_cast<std::size_t>(m - 1)) = std::sqrt(power - noise);
            if (power <= strongest) continue;
            strongest = power;
            mains.hz = nominal + std::arg(line->turn) / (two_pi * block_s) / m;
        }
        const bool is_mains = strongest > 0 && std::abs(mains.hz / nominal - 1) < off_nominal;
        if (is_mains &&
            (!best || mains.amplitude_of(mains.strongest()) > best->amplitude_of(best->strongest())))
            best = mains;
    }
    return best;
}

std::vector<int> hidden_harmonics(const std::vector<double>& lines_hz, double frequency, int harmonics) {
    std::vector<int> hidden;
    for (int q = 1; q <= harmonics; ++q)
        if (std::ranges::any_of(lines_hz, [&](double hz) {
                return std::lround(hz / frequency) == q && periods_to_tell(hz / frequency, harmonics) == 0;
            }))
            hidden.push_back(q);
    return hidden;
}

}  // namespace shaker::control
