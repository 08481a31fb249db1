// The mock converter through plain libasound: behaviour on which clients of a kernel PCM rely.
#include "tests/mock/converter.hpp"

#include <alsa/asoundlib.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <fstream>
#include <memory>
#include <numeric>

#include "drivers/descriptor.hpp"
#include "drivers/hardware/alsa/config.hpp"
#include "tests/mock/converter_memory.hpp"
#include "tests/support/devices/mock_dac.hpp"
#include "tests/support/in_real_time.hpp"
#include "tests/support/program.hpp"

namespace shaker::mock {
namespace {

using test::MockDac;
constexpr snd_pcm_uframes_t period = 240, buffer = 14400;  // 300 ms: longer than this machine's stalls

/// A playback stream of S32, from the side of the application.
class Client {
public:
    enum class Empty { stops, repeats, is_silent };

    explicit Client(const MockDac& mock, Empty empty = Empty::stops)
        : handle_{alsa::open_alsa(alsa::Direction::playback, mock.settings.pcm, mock.settings.alsa_config)},
          pcm{static_cast<snd_pcm_t*>(handle_.get())} {
        snd_pcm_hw_params_t* hw = nullptr;
        snd_pcm_hw_params_malloc(&hw);
        snd_pcm_hw_params_any(pcm, hw);
        snd_pcm_hw_params_set_access(pcm, hw, SND_PCM_ACCESS_RW_INTERLEAVED);
        snd_pcm_hw_params_set_format(pcm, hw, SND_PCM_FORMAT_S32_LE);
        snd_pcm_hw_params_set_channels(pcm, hw, 2);
        snd_pcm_hw_params_set_rate(pcm, hw, 48000, 0);
        snd_pcm_hw_params_set_period_size(pcm, hw, period, 0);
        snd_pcm_hw_params_set_buffer_size(pcm, hw, buffer);
        EXPECT_EQ(snd_pcm_hw_params(pcm, hw), 0);
        snd_pcm_hw_params_free(hw);
        snd_pcm_sw_params_t* sw = nullptr;
        snd_pcm_uframes_t boundary = 0;
        snd_pcm_sw_params_malloc(&sw);
        snd_pcm_sw_params_current(pcm, sw);
        snd_pcm_sw_params_get_boundary(sw, &boundary);
        snd_pcm_sw_params_set_start_threshold(pcm, sw, boundary);
        if (empty != Empty::stops) snd_pcm_sw_params_set_stop_threshold(pcm, sw, boundary);
        if (empty == Empty::is_silent) snd_pcm_sw_params_set_silence_size(pcm, sw, boundary);
        EXPECT_EQ(snd_pcm_sw_params(pcm, sw), 0);
        snd_pcm_sw_params_free(sw);
        EXPECT_EQ(snd_pcm_prepare(pcm), 0);
    }

    /// `frames` of the count from `from` on, in the upper 24 bits; negative on the second channel.
    snd_pcm_sframes_t write_count(std::int32_t from, std::size_t frames) const {
        std::vector<std::array<std::int32_t, 2>> data(frames);
        for (auto& [a, b] : data) {
            a = 256 * from++;
            b = -a;
        }
        return snd_pcm_writei(pcm, data.data(), frames);
    }
    /// Waits until this number of frames has been played.
    void play(std::int64_t frames) const {
        std::int64_t room = 0;
        while ((room = snd_pcm_avail(pcm)) >= 0 && room < frames) snd_pcm_wait(pcm, 10);
    }

private:
    alsa::AlsaHandle handle_;

public:
    snd_pcm_t* pcm;
};

/// The drive's codes of [from, from + n) as the counts that were written.
std::vector<std::int64_t> heard(const MockDac& mock, std::size_t from, std::size_t n) {
    std::vector<std::int64_t> counts(n);
    for (std::size_t i = 0; i < n; ++i) counts[i] = mock.first.at(from + i) / 256;
    return counts;
}
std::vector<std::int64_t> counting(std::int64_t from, std::size_t n) {
    std::vector<std::int64_t> counts(n);
    std::iota(counts.begin(), counts.end(), from);
    return counts;
}

TEST(ConverterTest, ItsSamplesFollowItsOwnClock) {
    const MockDac mock{250};
    for (const std::int64_t n : {1, 1000, 48000, 480000000}) {
        const HostTime at = mock.converter.time_of(n);
        EXPECT_EQ(mock.converter.due(at + std::chrono::nanoseconds{20}), n);
        EXPECT_EQ(mock.converter.due(at - std::chrono::nanoseconds{20}), n - 1);
    }
    const Seconds of_48000 = mock.converter.time_of(48000) - mock.converter.time_of(0);
    EXPECT_NEAR(of_48000.count(), 1 - 250e-6, 1e-7);  // 250e-6 squared is 6e-8
}

TEST(ConverterTest, WithoutAClientItIsSilent) {
    MockDac mock;
    mock.listen_for(Seconds{0.02});
    EXPECT_GE(mock.first.size(), 960U);
    EXPECT_EQ(mock.end_of_sound(), 0U);
    EXPECT_EQ(mock.converter.counts().streams, 0U);
}

TEST(ConverterTest, PlaysAndLogsBothChannels) {
    const auto log = std::filesystem::path{testing::TempDir()} / "converter_test_log";
    MockDac mock{0, log};
    {
        const Client client{mock};
        ASSERT_EQ(client.write_count(1, 2400), 2400);
        ASSERT_EQ(snd_pcm_start(client.pcm), 0);
        mock.listen_for(Seconds{0.07});
    }
    if (!test::in_real_time) return;
    const auto start = static_cast<std::size_t>(mock.converter.stream_starts().at(0));
    EXPECT_EQ(heard(mock, start, 2400), counting(1, 2400));
    EXPECT_EQ(mock.end_of_sound(), start + 2400);
    std::ifstream file{log, std::ios::binary};
    for (std::size_t i = 0; i < mock.first.size(); ++i) {
        std::array<std::int32_t, 2> codes{};
        file.read(reinterpret_cast<char*>(codes.data()), sizeof codes);
        ASSERT_TRUE(file) << i;
        ASSERT_EQ(codes[0], mock.first[i]) << i;
        ASSERT_EQ(codes[1], mock.second[i]) << i;
        ASSERT_EQ(codes[1], -codes[0]) << i;
    }
    std::filesystem::remove(log);
}

TEST(ConverterTest, FramesTakenBackAreNotPlayed) {
    MockDac mock;
    const Client client{mock};
    ASSERT_EQ(client.write_count(0, buffer), static_cast<snd_pcm_sframes_t>(buffer));
    ASSERT_EQ(snd_pcm_start(client.pcm), 0);
    ASSERT_EQ(snd_pcm_rewind(client.pcm, 1000), 1000);
    ASSERT_EQ(client.write_count(70000, 700), 700);
    mock.listen_for(Seconds{0.32});
    const auto start = static_cast<std::size_t>(mock.converter.stream_starts().at(0));
    EXPECT_EQ(heard(mock, start, buffer - 1000), counting(0, buffer - 1000));
    EXPECT_EQ(heard(mock, start + buffer - 1000, 700), counting(70000, 700));
    EXPECT_EQ(mock.end_of_sound(), start + buffer - 300);
}

TEST(ConverterTest, PlaysOnlyCompletedWrites) {
    const auto memory = std::make_unique<ConverterMemory>();
    for (std::int64_t i = 100; i < 200; ++i) memory->put(i, 1, 1, 1);
    for (std::int64_t i = 150; i < 180; ++i) memory->stage(i).put(i, 2, 2, 2);  // and then it died
    for (std::int64_t i = 100; i < 200; ++i) EXPECT_EQ(memory->heard(i).first, 1);
    memory->commit = std::uint64_t{150} << 20U | 30U;  // or it died after this
    for (std::int64_t i = 100; i < 200; ++i) EXPECT_EQ(memory->heard(i).first, i < 150 || i >= 180 ? 1 : 2);
    memory->publish(150, 180);
    for (std::int64_t i = 150; i < 180; ++i) EXPECT_EQ(memory->slot(i).first, 2);
}

TEST(ConverterTest, EmptyStreamStopsAndReportsIt) {
    MockDac mock;
    const Client client{mock};
    ASSERT_EQ(client.write_count(1, 480), 480);
    ASSERT_EQ(snd_pcm_start(client.pcm), 0);
    mock.listen_for(Seconds{0.05});
    EXPECT_EQ(snd_pcm_avail(client.pcm), -EPIPE);
    EXPECT_EQ(snd_pcm_state(client.pcm), SND_PCM_STATE_XRUN);
    EXPECT_EQ(mock.converter.counts().underruns, 1U);
    EXPECT_EQ(snd_pcm_recover(client.pcm, -EPIPE, 1), 0);
    ASSERT_EQ(client.write_count(5000, 480), 480);
    ASSERT_EQ(snd_pcm_start(client.pcm), 0);
    mock.listen_for(Seconds{0.05});
    EXPECT_EQ(heard(mock, static_cast<std::size_t>(mock.converter.stream_starts().at(1)), 480),
              counting(5000, 480));
}

TEST(ConverterTest, EndlessStreamRepeatsRingUnlessSilenced) {
    for (const auto empty : {Client::Empty::repeats, Client::Empty::is_silent}) {
        MockDac mock;
        const Client client{mock, empty};
        ASSERT_EQ(client.write_count(1, buffer), static_cast<snd_pcm_sframes_t>(buffer));
        ASSERT_EQ(snd_pcm_start(client.pcm), 0);
        mock.listen_for(Seconds{0.65});
        const auto start = static_cast<std::size_t>(mock.converter.stream_starts().at(0));
        EXPECT_EQ(heard(mock, start, buffer), counting(1, buffer));
        const bool repeats = empty == Client::Empty::repeats;
        EXPECT_EQ(heard(mock, start + buffer, buffer),
                  repeats ? counting(1, buffer) : std::vector<std::int64_t>(buffer));
        EXPECT_EQ(mock.converter.counts().replayed > 0, repeats);
        EXPECT_EQ(mock.converter.counts().underruns, 0U);
    }
}

TEST(ConverterTest, AnOrderlyEndIsSilentAtOnce) {
    MockDac mock;
    {
        const Client client{mock};
        ASSERT_EQ(client.write_count(1, buffer), static_cast<snd_pcm_sframes_t>(buffer));
        ASSERT_EQ(snd_pcm_start(client.pcm), 0);
        client.play(480);
    }
    mock.listen();
    const std::size_t closed = mock.first.size();
    mock.listen_for(Seconds{0.32});
    EXPECT_LE(mock.end_of_sound(), closed);
    EXPECT_GE(mock.end_of_sound(), 480U);
}

TEST(ConverterTest, ItHasOneClientAtATime) {
    const MockDac mock;
    const Client client{mock};
    try {
        alsa::open_alsa(alsa::Direction::playback, mock.settings.pcm, mock.settings.alsa_config);
        FAIL() << "opened twice";
    } catch (const std::exception& e) {
        EXPECT_NE(std::string{e.what()}.find("busy"), std::string::npos) << e.what();
    }
}

TEST(ConverterTest, UnpluggedItIsNoDevice) {
    MockDac mock;
    const Client client{mock};
    ASSERT_EQ(client.write_count(1, 2400), 2400);
    ASSERT_EQ(snd_pcm_start(client.pcm), 0);
    mock.converter.unplug();
    EXPECT_EQ(client.write_count(1, 240), -ENODEV);
    EXPECT_EQ(snd_pcm_state(client.pcm), SND_PCM_STATE_DISCONNECTED);
    EXPECT_EQ(snd_pcm_recover(client.pcm, -ENODEV, 1), -ENODEV);
    mock.listen();
    const std::size_t gone = mock.first.size();
    mock.listen_for(Seconds{0.06});
    EXPECT_LE(mock.end_of_sound(), gone);
}

TEST(ConverterTest, PositionIsConstantDuringStall) {
    MockDac mock;
    const Client client{mock};
    ASSERT_EQ(client.write_count(1, buffer), static_cast<snd_pcm_sframes_t>(buffer));
    ASSERT_EQ(snd_pcm_start(client.pcm), 0);
    client.play(240);
    mock.converter.stall(Seconds{0.5});
    const snd_pcm_sframes_t room = snd_pcm_avail(client.pcm);
    mock.listen_for(Seconds{0.05});
    const snd_pcm_sframes_t later = snd_pcm_avail(client.pcm);
    EXPECT_LE(later - room, 1);
    mock.listen_for(Seconds{0.8});
    const auto sounding = std::count_if(mock.first.begin(), mock.first.end(), [](auto c) { return c != 0; });
    EXPECT_EQ(sounding, static_cast<std::ptrdiff_t>(buffer));  // nothing is omitted
    const auto start = static_cast<std::size_t>(mock.converter.stream_starts().at(0));
    EXPECT_EQ(mock.end_of_sound(), start + buffer + 24000);  // and 0.5 s are inserted
}

TEST(ConverterTest, AStartThatIsAnnouncedLateHasItsOwnSample) {
    const std::filesystem::path file = test::fresh_folder() / "converter";
    Converter converter{file, 48000, 0};
    const Descriptor mapped{::open(file.c_str(), O_RDWR | O_CLOEXEC)};
    void* const at = ::mmap(nullptr, sizeof(ConverterMemory), PROT_READ | PROT_WRITE, MAP_SHARED, mapped, 0);
    ASSERT_NE(at, MAP_FAILED);
    auto& memory = *static_cast<ConverterMemory*>(at);
    std::array<double, 100> first{}, second{};
    converter.take(first, second, {});
    memory.starts[0] = 40;
    ++memory.start_count;
    converter.take(first, second, {});
    EXPECT_EQ(converter.stream_starts(), std::vector<std::int64_t>{40});
    ::munmap(at, sizeof(ConverterMemory));
}

}  // namespace
}  // namespace shaker::mock
