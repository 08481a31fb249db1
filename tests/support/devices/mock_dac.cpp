#include "tests/support/devices/mock_dac.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <thread>

#include "tests/support/paths.hpp"

namespace shaker::test {

namespace {

constexpr double rate_hz = 48000, full_scale = 2147483648.0;

std::filesystem::path memory_folder() {
    const bool shm = std::filesystem::is_directory("/dev/shm");
    std::string name =
        (shm ? "/dev/shm" : std::filesystem::temp_directory_path().string()) + "/shaker-XXXXXX";
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error{"no temporary folder"};
    return name;
}

}  // namespace

MockDac::MockDac(double ppm, const std::filesystem::path& log)
    : folder{memory_folder()}, converter{folder / "converter", rate_hz, ppm, log} {
    std::ofstream{folder / "asound.conf"}
        << "pcm_type.shaker_mock { lib \"" + test::build_dir() + "/shaker_mock_pcm.so\" }\n"
        << "pcm.shaker { type shaker_mock converter \"" << (folder / "converter").string() << "\" }\n";
    settings.pcm = "shaker";
    settings.alsa_config = folder / "asound.conf";
    settings.period_frames = 480;
    settings.buffer_frames = 9600;
}

MockDac::~MockDac() {
    std::error_code ignored;
    std::filesystem::remove_all(folder, ignored);
}

void MockDac::listen() {
    const auto due = static_cast<std::size_t>(converter.due(mock::host_now()) - converter.taken());
    std::vector<double> a(due), b(due), c(due);
    converter.take(a, b, c);
    const auto code = [](double share) { return std::llround(share * full_scale); };
    std::transform(a.begin(), a.end(), std::back_inserter(first), code);
    std::transform(b.begin(), b.end(), std::back_inserter(second), code);
    std::transform(c.begin(), c.end(), std::back_inserter(third), code);
}

void MockDac::listen_for(Seconds duration) {
    const HostTime until = mock::host_now() + std::chrono::duration_cast<std::chrono::nanoseconds>(duration);
    while (mock::host_now() < until) {
        std::this_thread::sleep_for(std::chrono::milliseconds{5});
        listen();
    }
}

std::size_t MockDac::next_sound(std::size_t from) const {
    const auto sound = [](std::int64_t code) { return code != 0; };
    return static_cast<std::size_t>(
        std::find_if(first.begin() + static_cast<std::ptrdiff_t>(from), first.end(), sound) - first.begin());
}

std::size_t MockDac::end_of_sound() const {
    std::size_t end = first.size();
    while (end > 0 && first[end - 1] == 0) --end;
    return end;
}

double MockDac::largest_step(std::size_t from, std::size_t until) const {
    std::int64_t largest = 0;
    for (std::size_t i = from + 1; i < until; ++i)
        largest = std::max(largest, std::abs(first[i] - first[i - 1]));
    return static_cast<double>(largest) / full_scale;
}

double test_drive(std::int64_t tick) {
    const double turns = static_cast<double>(tick % 480) / 480;
    return 0.3 * std::sin(2 * std::numbers::pi * turns) + 0.3 * std::sin(4 * std::numbers::pi * turns);
}

std::vector<double> test_block(std::int64_t tick, std::size_t n) {
    std::vector<double> block(n);
    for (std::size_t i = 0; i < n; ++i) block[i] = test_drive(tick + static_cast<std::int64_t>(i));
    return block;
}

}  // namespace shaker::test
