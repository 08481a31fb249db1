#include "tests/mock/gige_features.hpp"

#include <initializer_list>
#include <sstream>
#include <string_view>
#include <utility>

namespace shaker::mock {
namespace {

using Entries = std::initializer_list<std::pair<std::string_view, std::uint32_t>>;

/// Writes the nodes of a description.
class Features {
public:
    std::string text() const { return xml_.str(); }

    void category(std::string_view name, std::initializer_list<std::string_view> members) {
        xml_ << "<Category Name=\"" << name << "\">";
        for (const auto member : members) xml_ << "<pFeature>" << member << "</pFeature>";
        xml_ << "</Category>\n";
    }
    void text_register(std::string_view name, std::uint32_t address, int length) {
        xml_ << "<StringReg Name=\"" << name << "\"><Address>" << address << "</Address><Length>" << length
             << "</Length><AccessMode>RO</AccessMode><pPort>Device</pPort></StringReg>\n";
    }
    void number_register(std::string_view name, GigeRegister address, std::string_view access = "RW") {
        begin("IntReg", name);
        xml_ << "<Address>" << static_cast<std::uint32_t>(address) << "</Address><Length>4</Length>"
             << "<AccessMode>" << access << "</AccessMode><pPort>Device</pPort><Cachable>NoCache</Cachable>"
             << "<Sign>Unsigned</Sign><Endianess>BigEndian</Endianess></IntReg>\n";
    }
    void integer(std::string_view name, GigeRegister address, std::string_view limits,
                 std::string_view access = "RW") {
        node("Integer", name, limits);
        number_register(registered(name), address, access);
    }
    /// Converts to units of the register: FROM is the feature's value, TO the register's.
    void scaled(std::string_view name, GigeRegister address, double per_unit, std::string_view limits) {
        const std::string converter = std::string{name} + "Converter";
        begin("Float", name);
        xml_ << "<pValue>" << converter << "</pValue>" << limits << "</Float>\n";
        begin("Converter", converter);
        xml_ << "<FormulaTo>FROM * " << per_unit << "</FormulaTo><FormulaFrom>TO / " << per_unit
             << "</FormulaFrom><pValue>" << registered(name) << "</pValue></Converter>\n";
        number_register(registered(name), address);
    }
    void choice(std::string_view name, GigeRegister address, Entries entries,
                std::string_view access = "RW") {
        begin("Enumeration", name);
        for (const auto& [entry, value] : entries)
            xml_ << "<EnumEntry Name=\"" << entry << "\"><Value>" << value << "</Value></EnumEntry>";
        xml_ << "<pValue>" << registered(name) << "</pValue></Enumeration>\n";
        number_register(registered(name), address, access);
    }
    void flag(std::string_view name, GigeRegister address) {
        node("Boolean", name, "<OnValue>1</OnValue><OffValue>0</OffValue>");
        number_register(registered(name), address);
    }
    void command(std::string_view name, std::string_view register_name, int value) {
        begin("Command", name);
        xml_ << "<pValue>" << register_name << "</pValue><CommandValue>" << value
             << "</CommandValue></Command>\n";
    }
    void chunk(const GigeChunk& chunk, std::string_view kind) {
        const std::string name = std::string{"Chunk"} + chunk.name;
        node(kind, name, "");
        begin("IntReg", registered(name));
        xml_ << "<Address>0</Address><Length>" << chunk.bytes << "</Length><AccessMode>RO</AccessMode><pPort>"
             << name << "Port</pPort><Cachable>NoCache</Cachable><Sign>Unsigned</Sign>"
             << "<Endianess>BigEndian</Endianess></IntReg>\n";
        begin("Port", name + "Port");
        xml_ << "<ChunkID>" << std::hex << chunk.id << std::dec << "</ChunkID></Port>\n";
    }
    void raw(std::string_view text) { xml_ << text; }

private:
    static std::string registered(std::string_view name) { return std::string{name} + "Register"; }
    void begin(std::string_view kind, std::string_view name) {
        xml_ << '<' << kind << " Name=\"" << name << "\">";
    }
    void node(std::string_view kind, std::string_view name, std::string_view inside) {
        begin(kind, name);
        xml_ << "<pValue>" << registered(name) << "</pValue>" << inside << "</" << kind << ">\n";
    }

    std::ostringstream xml_;
};

constexpr std::string_view header = R"(<?xml version="1.0" encoding="utf-8"?>
<RegisterDescription ModelName="Mock" VendorName="Shaker" StandardNameSpace="GEV" SchemaMajorVersion="1"
 SchemaMinorVersion="0" SchemaSubMinorVersion="1" MajorVersion="1" MinorVersion="0" SubMinorVersion="0"
 ToolTip="Camera of the mock bench" ProductGuid="0" VersionGuid="0"
 xmlns="http://www.genicam.org/GenApi/Version_1_0">
)";

// Bytes of a picture in the stream: its pixels, rounded up to a byte, and 8 bytes per chunk in addition to
// its data.
constexpr std::string_view payload_size = R"(<IntSwissKnife Name="PayloadSize">
<pVariable Name="W">Width</pVariable><pVariable Name="H">Height</pVariable>
<pVariable Name="F">PixelFormatRegister</pVariable><pVariable Name="M">ChunkModeActiveRegister</pVariable>
<pVariable Name="A">ChunkFrameIDOn</pVariable><pVariable Name="B">ChunkTimestampOn</pVariable>
<pVariable Name="C">ChunkExposureTimeOn</pVariable>
<Formula>(W * H * ((F &gt;&gt; 16) &amp; 255) + 7) / 8 + M * 16 * (A + B + C)</Formula></IntSwissKnife>
)";

constexpr std::string_view chunk_enable = R"(<Boolean Name="ChunkEnable"><pValue>ChunkEnableRegister</pValue>
<OnValue>1</OnValue><OffValue>0</OffValue></Boolean>
<IntReg Name="ChunkEnableRegister"><Address>0x8068</Address>
<pIndex Offset="4">ChunkSelectorRegister</pIndex><Length>4</Length><AccessMode>RW</AccessMode>
<pPort>Device</pPort><Cachable>NoCache</Cachable><Sign>Unsigned</Sign><Endianess>BigEndian</Endianess></IntReg>
)";

constexpr GigeRegister after(GigeRegister address, std::uint32_t bytes) {
    return static_cast<GigeRegister>(static_cast<std::uint32_t>(address) + bytes);
}

void image_format(Features& f) {
    f.category("ImageFormatControl",
               {"SensorWidth", "SensorHeight", "OffsetX", "OffsetY", "Width", "Height", "PixelFormat"});
    f.integer("SensorWidth", GigeRegister::sensor_width, "", "RO");
    f.integer("SensorHeight", GigeRegister::sensor_height, "", "RO");
    f.integer("OffsetX", GigeRegister::x, "<Min>0</Min><pMax>SensorWidth</pMax>");
    f.integer("OffsetY", GigeRegister::y, "<Min>0</Min><pMax>SensorHeight</pMax>");
    f.integer("Width", GigeRegister::width, "<Min>4</Min><pMax>SensorWidth</pMax><Inc>4</Inc>");
    f.integer("Height", GigeRegister::height, "<Min>2</Min><pMax>SensorHeight</pMax><Inc>2</Inc>");
    f.choice("PixelFormat", GigeRegister::pixel_format,
             {{"Mono8", 0x01080001},
              {"Mono10", 0x01100003},
              {"Mono10Packed", 0x010c0004},
              {"Mono10p", 0x010a0046},
              {"Mono12", 0x01100005},
              {"Mono12Packed", 0x010c0006},
              {"Mono12p", 0x010c0047},
              {"Mono16", 0x01100007}});
}

void collector(Features& f) {
    f.category("AcquisitionControl",
               {"AcquisitionMode", "AcquisitionStart", "AcquisitionStop", "AcquisitionFrameRateEnable",
                "AcquisitionFrameRate", "ExposureTime", "TriggerSelector", "TriggerMode", "TriggerSource",
                "TriggerActivation", "TriggerSoftware"});
    f.choice("AcquisitionMode", GigeRegister::acquisition_mode, {{"Continuous", 0}, {"SingleFrame", 1}});
    f.number_register("AcquisitionRegister", GigeRegister::collector);
    f.command("AcquisitionStart", "AcquisitionRegister", 1);
    f.command("AcquisitionStop", "AcquisitionRegister", 0);
    f.flag("AcquisitionFrameRateEnable", GigeRegister::frame_rate_enable);
    f.scaled("AcquisitionFrameRate", GigeRegister::frame_rate_mhz, 1000, "<Min>1</Min><Max>2000</Max>");
    f.scaled("ExposureTime", GigeRegister::exposure_us, 1, "<Min>10</Min><Max>1000000</Max>");
    f.raw(
        "<Enumeration Name=\"TriggerSelector\"><EnumEntry Name=\"FrameStart\"><Value>0</Value></EnumEntry>"
        "<Value>0</Value></Enumeration>\n");
    f.choice("TriggerMode", GigeRegister::trigger_mode, {{"Off", 0}, {"On", 1}});
    f.choice("TriggerSource", GigeRegister::trigger_source, {{"Line0", 0}, {"Line1", 1}, {"Software", 2}});
    f.choice("TriggerActivation", GigeRegister::trigger_activation, {{"RisingEdge", 0}});
    f.number_register("TriggerSoftwareRegister", GigeRegister::trigger_software);
    f.command("TriggerSoftware", "TriggerSoftwareRegister", 1);
}

void chunks(Features& f) {
    f.category("ChunkDataControl", {"ChunkModeActive", "ChunkSelector", "ChunkEnable", "ChunkFrameID",
                                    "ChunkTimestamp", "ChunkExposureTime"});
    f.flag("ChunkModeActive", GigeRegister::chunk_mode);
    f.choice("ChunkSelector", GigeRegister::chunk_selector,
             {{"FrameID", 0}, {"Timestamp", 1}, {"ExposureTime", 2}});
    f.raw(chunk_enable);
    std::uint32_t bytes = 0;
    for (const GigeChunk& chunk : gige_chunks) {
        f.chunk(chunk, std::string_view{chunk.name} == "ExposureTime" ? "Float" : "Integer");
        f.number_register(std::string{"Chunk"} + chunk.name + "On", after(GigeRegister::chunk_enable, bytes));
        bytes += 4;
    }
}

}  // namespace

std::string gige_features_xml() {
    Features f;
    f.raw(header);
    f.category("Root", {"DeviceControl", "ImageFormatControl", "AcquisitionControl", "AnalogControl",
                        "ChunkDataControl", "TransportLayerControl"});
    f.category("DeviceControl",
               {"DeviceVendorName", "DeviceModelName", "DeviceVersion", "DeviceSerialNumber"});
    f.text_register("DeviceVendorName", 0x48, 32);
    f.text_register("DeviceModelName", 0x68, 32);
    f.text_register("DeviceVersion", 0x88, 32);
    f.text_register("DeviceSerialNumber", 0xd8, 16);
    image_format(f);
    collector(f);
    f.category("AnalogControl", {"Gain"});
    f.scaled("Gain", GigeRegister::gain_tenths_db, 10, "<Min>0</Min><Max>24</Max>");
    chunks(f);
    f.category("TransportLayerControl", {"PayloadSize", "PtpEnable", "PtpStatus"});
    f.raw(payload_size);
    f.flag("PtpEnable", GigeRegister::ptp_enable);
    f.choice("PtpStatus", GigeRegister::ptp_status, {{"Disabled", 0}, {"Listening", 1}, {"Slave", 4}});
    f.raw("<Port Name=\"Device\"></Port>\n</RegisterDescription>\n");
    return f.text();
}

}  // namespace shaker::mock
