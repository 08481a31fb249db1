#pragma once
// An analog accelerometer on the inputs of a sound card.
#include <memory>

#include "drivers/devices.hpp"
#include "drivers/hardware/alsa_input/settings.hpp"
#include "drivers/hardware/kind/device_kind.hpp"

namespace shaker::alsa_input {

/// Opens the input; the first read() starts it. Samples of the card are reduced by RateReducer to those of
/// the sensor; their stamps have its delay. A count is full scale / 2^31, so that the reduction loses no
/// bits. Samples at full scale are clipped. After an overrun the stamps show how many samples are missing,
/// and the next block begins on the grid of the samples before; the filter needs 4 ms at 4 kHz until then. A
/// device that vanishes is opened again twice a second; without data for give_up_s read() throws DeviceError.
/// `notes`: what the device granted. Throws DeviceError.
std::unique_ptr<Accelerometer> open_alsa_accelerometer(const InputSettings& settings, hardware::Notes& notes);

/// Left-justified code of a sample in memory.
std::int32_t code_at(const std::byte* at, alsa::SampleFormat format) noexcept;

}  // namespace shaker::alsa_input
