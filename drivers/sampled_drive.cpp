#include "drivers/sampled_drive.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "drivers/errors.hpp"
#include "drivers/quantity.hpp"

namespace shaker {

namespace {

constexpr double most_left_out = 0.01;  // of the rms
constexpr double nothing = 1e-9;        // of the largest sample

/// Amplitude of harmonic q, as Harmonics has it.
std::complex<double> amplitude(std::span<const double> a, int q) {
    const auto n = static_cast<double>(a.size());
    std::complex<double> sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        sum += a[i] * std::polar(1.0, -two_pi * std::fmod(q * static_cast<double>(i), n) / n);
    return std::complex<double>{0, 2 / n} * sum;
}

}  // namespace

Drive drive_of_period(std::span<const double> acceleration, double frequency) {
    if (acceleration.size() < least_period_samples)
        throw InputError{"the period has " + std::to_string(acceleration.size()) + " samples; " +
                         std::to_string(least_period_samples) + " or more are required for harmonics 1 to " +
                         std::to_string(most_driven)};
    if (!std::ranges::all_of(acceleration, [](double x) { return std::isfinite(x); }))
        throw InputError{"the period has samples that are not finite"};
    double mean = 0, power = 0, kept = 0, largest = 0;
    const auto n = static_cast<double>(acceleration.size());
    for (const double x : acceleration) {
        mean += x / n;
        largest = std::max(largest, std::abs(x));
    }
    for (const double x : acceleration) power += (x - mean) * (x - mean) / n;
    Harmonics<Acceleration> h;
    for (int q = 1; q <= most_driven; ++q) {
        h.at(q) = amplitude(acceleration, q);
        kept += std::norm(h.at(q)) / 2;
    }
    const double left_out = std::sqrt(std::max(0.0, power - kept) / power);
    Drive drive = drive_of(h, frequency);
    if (!(drive.gamma > nothing * largest))
        throw InputError{"the period has no harmonics 1 and 2: gamma would be 0"};
    if (left_out > most_left_out)
        throw InputError{to_text(std::round(1e4 * left_out) / 100) +
                         " % of the period's rms is in harmonics above " + std::to_string(most_driven) +
                         "; at most " + to_text(100 * most_left_out) + " % is allowed"};
    for (int q = 3; q <= most_driven; ++q)
        drive.overtones[static_cast<std::size_t>(q - 3)] =
            h.at(q) / drive.gamma * std::polar(1.0, -q * std::arg(h.at(1)));
    return drive;
}

}  // namespace shaker
