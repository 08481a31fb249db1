#pragma once
// MockMixer: the controls of a mock sound card behind the plug-in of libasound.
#include <filesystem>
#include <string>

namespace shaker::mock {

struct MixerMemory;

/// Any thread.
class MockMixer {
public:
    /// Creates `file`, which the plug-in maps, and removes it at the end. Throws DeviceError.
    explicit MockMixer(const std::filesystem::path& file);
    MockMixer(const MockMixer&) = delete;
    MockMixer& operator=(const MockMixer&) = delete;
    ~MockMixer();

    /// The playback volume of all channels, 0..255, as another program would set it.
    void set_volume(long value) noexcept;
    [[nodiscard]] long volume() const noexcept;

private:
    std::filesystem::path file_;
    MixerMemory* memory_;
};

}  // namespace shaker::mock
