// Plays the test drive through AlsaDac to a sound server and searches it in the output of the server.
//
//   peer_alsa_player play CONFIG PCM SECONDS   until the time is over or the device fails (exit status 3)
//   peer_alsa_player compare RAW SECONDS TICK... RAW: captured S32 frames of two channels; TICK: where
//                                              playing began, as `play` printed them
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "drivers/errors.hpp"
#include "drivers/hardware/alsa/alsa_dac.hpp"
#include "drivers/hardware/alsa/output_frames.hpp"
#include "tests/support/remote/player.hpp"

namespace shaker {
namespace {

using Clock = std::chrono::steady_clock;
constexpr int rate_hz = 48000;

double cpu_s() {
    rusage used{};
    ::getrusage(RUSAGE_SELF, &used);
    const auto seconds = [](const timeval& t) {
        return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return seconds(used.ru_utime) + seconds(used.ru_stime);
}

int play(const std::string& config, const std::string& pcm, double seconds) {
    alsa::AlsaSettings settings;
    settings.pcm = pcm;
    settings.alsa_config = config;
    settings.rate_hz = rate_hz;
    settings.period_frames = 480;
    settings.buffer_frames = 9600;
    settings.second_channel = alsa::SecondChannel::tone;
    alsa::AlsaDac dac{settings};
    std::printf("%s\n", dac.granted().text().c_str());
    std::fflush(stdout);
    test::Player player{dac};
    const auto blocks = static_cast<std::size_t>(seconds * rate_hz / test::Player::block);
    Clock::time_point last_good = Clock::now();
    double cpu_then = cpu_s();
    int status = 0;
    try {
        for (std::size_t i = 0; i < blocks; ++i) {
            const bool good = player.play().lost == 0;
            if (!good) continue;
            last_good = Clock::now();
            cpu_then = cpu_s();
        }
    } catch (const DeviceError& e) {
        const Seconds since = Clock::now() - last_good;
        std::printf("given up %.3f s after the last block, %.3f s of them on the processor: %s\n",
                    since.count(), cpu_s() - cpu_then, e.what());
        status = 3;
    }
    std::printf("began at 0");
    for (const std::int64_t tick : player.resumed) std::printf(" %lld", static_cast<long long>(tick));
    const DeviceCounts counts = dac.counts();
    std::printf("\n%llu samples played, %llu lost, %llu incidents, reopened %llu times\n",
                static_cast<unsigned long long>(counts.taken), static_cast<unsigned long long>(counts.lost),
                static_cast<unsigned long long>(counts.incidents),
                static_cast<unsigned long long>(counts.reopened));
    return status;
}

int compare(const std::string& file, double seconds, const std::vector<std::int64_t>& ticks) {
    std::ifstream in{file, std::ios::binary};
    const std::string bytes{std::istreambuf_iterator<char>{in}, {}};
    std::vector<std::int32_t> drive(bytes.size() / 8);
    for (std::size_t i = 0; i < drive.size(); ++i)
        std::memcpy(&drive[i], bytes.data() + 8 * i, sizeof drive[i]);
    const alsa::PcmCodec codec{alsa::SampleFormat::s32, 0, 1};
    const auto matching_from = [&](std::size_t at, std::int64_t first) {
        std::size_t n = 0;
        for (; at + n < drive.size(); ++n) {
            const DacTick tick{first + static_cast<std::int64_t>(n)};
            if (drive[at + n] != 256 * codec.dithered(test::test_drive(tick.n), tick, 0)) break;
        }
        return n;
    };
    std::size_t longest = 0;
    for (const std::int64_t tick : ticks)
        for (std::size_t at = 0; at < drive.size(); ++at)
            longest = std::max(longest, matching_from(at, tick));
    std::printf("%zu samples in a row are the codes that were played\n", longest);
    return static_cast<double>(longest) >= seconds * rate_hz ? 0 : 1;
}

}  // namespace
}  // namespace shaker

int main(int argc, char** argv) {
    const std::vector<std::string> args(argv + 1, argv + argc);
    try {
        if (args.size() == 4 && args[0] == "play") return shaker::play(args[1], args[2], std::stod(args[3]));
        if (args.size() > 3 && args[0] == "compare") {
            std::vector<std::int64_t> ticks;
            for (std::size_t i = 3; i < args.size(); ++i) ticks.push_back(std::stoll(args[i]));
            return shaker::compare(args[1], std::stod(args[2]), ticks);
        }
        std::fprintf(stderr, "peer_alsa_player play CONFIG PCM SECONDS | compare RAW SECONDS TICK...\n");
    } catch (const std::exception& e) {
        std::fprintf(stderr, "%s\n", e.what());
    }
    return 2;
}
