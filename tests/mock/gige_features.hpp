#pragma once
// GenICam description of the mock camera and the addresses of its features. Aravis' fake camera acts on none
// of these registers: it serves the control channel and never streams by itself.
#include <cstdint>
#include <string>

namespace shaker::mock {

/// Addresses of 4-byte big-endian registers.
enum class GigeRegister : std::uint32_t {
    sensor_width = 0x8000,
    sensor_height = 0x8004,
    x = 0x8008,
    y = 0x800c,
    width = 0x8010,
    height = 0x8014,
    pixel_format = 0x8018,  // PFNC code
    collector = 0x8020,     // 1 = running
    acquisition_mode = 0x8024,
    frame_rate_enable = 0x8028,
    frame_rate_mhz = 0x802c,  // millihertz
    exposure_us = 0x8030,
    trigger_mode = 0x8034,        // 1 = on
    trigger_source = 0x8038,      // 0 = Line0, 1 = Line1, 2 = Software
    trigger_software = 0x803c,    // the client writes 1, the camera writes 0 after the exposure
    trigger_activation = 0x8040,  // 0 = rising edge
    gain_tenths_db = 0x8044,
    ptp_enable = 0x8050,
    ptp_status = 0x8054,  // 4 = Slave
    chunk_mode = 0x8060,
    chunk_selector = 0x8064,
    chunk_enable = 0x8068,      // one per chunk, 4 bytes apart: frame id, time stamp, exposure time
    stream_port = 0x0d00,       // bootstrap registers of every GigE Vision camera
    stream_packet = 0x0d04,     // low half: packet size in bytes, headers included
    stream_address = 0x0d18,    // IPv4
    control_privilege = 0x0a00  // not 0 while a client controls the camera
};

/// Chunks that the camera can append to a picture, in the order of chunk_enable; each is one big-endian
/// number.
struct GigeChunk {
    const char* name;  // as in ChunkSelector
    std::uint32_t id;
    int bytes;
};
inline constexpr GigeChunk gige_chunks[] = {
    {"FrameID", 0x10, 8}, {"Timestamp", 0x11, 8}, {"ExposureTime", 0x12, 8}};

/// The description with all limits, such as the longest exposure and the highest rate.
std::string gige_features_xml();

}  // namespace shaker::mock
