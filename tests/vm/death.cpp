#include "tests/vm/death.hpp"

#include <alsa/asoundlib.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <memory>
#include <numbers>
#include <thread>
#include <vector>

#include "drivers/errors.hpp"
#include "drivers/hardware/alsa/alsa_dac.hpp"

namespace shaker {

namespace {

constexpr double full_scale = 2147483648.0;
constexpr auto loud = static_cast<std::int32_t>(0.1 * full_scale);

// The recording side of the card.
class Capture {
public:
    Capture(const std::string& name, int rate_hz) {
        snd_pcm_t* pcm = nullptr;
        check(snd_pcm_open(&pcm, name.c_str(), SND_PCM_STREAM_CAPTURE, SND_PCM_NONBLOCK));
        pcm_.reset(pcm);
        constexpr unsigned latency_us = 2'000'000;
        check(snd_pcm_set_params(pcm, SND_PCM_FORMAT_S32_LE, SND_PCM_ACCESS_RW_INTERLEAVED, 2,
                                 static_cast<unsigned>(rate_hz), 0, latency_us));
        check(snd_pcm_start(pcm));
    }

    /// Reads the captured samples.
    void listen() {
        std::array<std::int32_t, 2048> frames{};
        for (;;) {
            const snd_pcm_sframes_t n = snd_pcm_readi(pcm_.get(), frames.data(), frames.size() / 2);
            if (n == -EAGAIN || n == 0) return;
            check(static_cast<int>(n));
            for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) first.push_back(frames[2 * i]);
        }
    }
    void listen_for(Seconds duration) {
        auto last = std::chrono::steady_clock::now();
        const auto until = last + duration;
        while (last < until) {
            std::this_thread::sleep_for(std::chrono::milliseconds{20});
            listen();
            const auto now = std::chrono::steady_clock::now();
            longest_pause = std::max<Seconds>(longest_pause, now - last);
            last = now;
        }
    }

    std::vector<std::int32_t> first;  // channel
    Seconds longest_pause{};

private:
    static void check(int error) {
        if (error < 0) throw DeviceError{std::string{"capture: "} + snd_strerror(error)};
    }
    struct Close {
        void operator()(snd_pcm_t* pcm) const noexcept { snd_pcm_close(pcm); }
    };
    std::unique_ptr<snd_pcm_t, Close> pcm_;
};

constexpr std::size_t cycle = 480;
std::array<double, cycle> one_cycle() {
    std::array<double, cycle> volts{};
    for (std::size_t i = 0; i < cycle; ++i) {
        const double phase = 2 * std::numbers::pi * static_cast<double>(i) / cycle;
        volts[i] = 0.3 * std::sin(phase) + 0.3 * std::sin(2 * phase);
    }
    return volts;
}

[[noreturn]] void drive(const alsa::AlsaSettings& settings) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    try {
        alsa::AlsaDac dac{settings};
        const auto volts = one_cycle();
        const std::array<double, cycle> no_trigger{};
        for (;;) dac.write(volts, no_trigger);
    } catch (const std::exception& e) {
        std::printf("the driving process: %s\n", e.what());
        std::fflush(stdout);
    }
    ::_exit(1);
}

double share(std::int64_t code) { return std::abs(static_cast<double>(code)) / full_scale; }

}  // namespace

AfterDeath hear_a_death(const alsa::AlsaSettings& settings, const std::string& capture, Seconds duration,
                        End end) {
    Capture heard{capture, settings.rate_hz};
    std::fflush(stdout);
    const pid_t driving = ::fork();
    if (driving == 0) drive(settings);
    const auto sounds = [&] {
        return std::any_of(heard.first.begin(), heard.first.end(), [](auto code) { return code > loud; });
    };
    const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds{60};
    while (!sounds() && std::chrono::steady_clock::now() < patience) {
        heard.first.clear();
        heard.listen_for(Seconds{0.2});
    }
    heard.listen_for(duration);
    const auto ended = static_cast<std::int64_t>(heard.first.size());
    ::kill(driving, end == End::killed ? SIGKILL : SIGSTOP);
    heard.listen_for(Seconds{1});

    AfterDeath result;
    result.longest_pause = heard.longest_pause;
    const auto volts = one_cycle();
    for (std::size_t i = 0; i < cycle; ++i)
        result.drive_step = std::max(result.drive_step, std::abs(volts[(i + 1) % cycle] - volts[i]));
    result.drive_step /= settings.full_scale_V;
    for (std::size_t i = 1; i < heard.first.size(); ++i) {
        const std::int64_t code = heard.first[i];
        if (code != 0)
            result.sounds_on =
                Seconds{static_cast<double>(static_cast<std::int64_t>(i) + 1 - ended) / settings.rate_hz};
        result.level = std::max(result.level, share(code));
        result.largest_step = std::max(result.largest_step, share(code - heard.first[i - 1]));
    }
    ::kill(driving, SIGKILL);
    ::waitpid(driving, nullptr, 0);
    return result;
}

}  // namespace shaker
