#pragma once
// The mains in a sensor whose base is at rest: found before the first drive, because hum that is not in
// the settings looks like motion to the loop.
#include <array>
#include <complex>
#include <optional>
#include <vector>

namespace shaker::control {

/// Lines of the mains and of its multiples.
struct Mains {
    static constexpr int multiples = 4;
    double hz = 0;                              // of the mains, as measured
    std::array<double, multiples> amplitude{};  // m/s^2, at hz, 2 hz, ..., rms over 0.2 s and the root of the
                                                // squares of all axes; 0: not clear of the noise
    /// The multiple with the largest amplitude, 1..multiples.
    [[nodiscard]] int strongest() const noexcept;
    [[nodiscard]] double amplitude_of(int multiple) const {
        return amplitude.at(static_cast<std::size_t>(multiple - 1));
    }
};

/// Compares 50 and 60 Hz and their multiples with what lies 5 Hz beside them, in blocks of 0.2 s, which hold
/// whole periods of each. A line counts where the power is 30 times that beside it, which neither noise nor a
/// sensor that settles makes. Not thread-safe.
class MainsWatch {
public:
    /// rate_hz: of the sensor. Lines above 0.45 of it are not looked for.
    explicit MainsWatch(double rate_hz);
    /// A sample in m/s^2 at a time in s; times increase. Takes the first 10 s.
    void add(double at_s, const std::array<double, 3>& a);
    /// Empty without mains, and before three whole blocks.
    [[nodiscard]] std::optional<Mains> found() const;

private:
    using Amplitude = std::array<std::complex<double>, 3>;
    struct Bin {
        double hz = 0;
        Amplitude now{}, before{};
        double power = 0;           // sum over blocks and axes
        std::complex<double> turn;  // of the phase from block to block, weighted by power
    };
    void finish();
    [[nodiscard]] const Bin* at(double hz) const noexcept;

    double rate_hz_;
    std::vector<Bin> bins_;
    std::array<double, 3> rest_{};    // the first sample: gravity and offset
    double from_s_ = 0, block_ = -1;  // its time; number of the present block from there on
    int samples_ = 0, blocks_ = 0;
    bool follows_ = false;  // the block before was whole
};

/// Harmonics 1..K of `frequency` (Hz), in the order of q, that are too near one of the lines (Hz) for a
/// window to separate the two.
std::vector<int> hidden_harmonics(const std::vector<double>& lines_hz, double frequency, int harmonics);

}  // namespace shaker::control
