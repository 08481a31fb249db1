#include "daemon/remote/scpi/error.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace shaker::scpi {
namespace {

constexpr std::array messages = std::to_array<std::pair<Code, std::string_view>>({
    {Code::none, "No error"},
    {Code::invalid_character, "Invalid character"},
    {Code::syntax, "Syntax error"},
    {Code::invalid_separator, "Invalid separator"},
    {Code::data_type, "Data type error"},
    {Code::parameter_not_allowed, "Parameter not allowed"},
    {Code::missing_parameter, "Missing parameter"},
    {Code::mnemonic_too_long, "Program mnemonic too long"},
    {Code::undefined_header, "Undefined header"},
    {Code::header_suffix_out_of_range, "Header suffix out of range"},
    {Code::invalid_character_in_number, "Invalid character in number"},
    {Code::exponent_too_large, "Exponent too large"},
    {Code::too_many_digits, "Too many digits"},
    {Code::numeric_not_allowed, "Numeric data not allowed"},
    {Code::invalid_suffix, "Invalid suffix"},
    {Code::suffix_not_allowed, "Suffix not allowed"},
    {Code::invalid_character_data, "Invalid character data"},
    {Code::character_data_not_allowed, "Character data not allowed"},
    {Code::invalid_string, "Invalid string data"},
    {Code::string_not_allowed, "String data not allowed"},
    {Code::invalid_block, "Invalid block data"},
    {Code::block_not_allowed, "Block data not allowed"},
    {Code::expression, "Expression error"},
    {Code::execution, "Execution error"},
    {Code::command_protected, "Command protected"},
    {Code::trigger_ignored, "Trigger ignored"},
    {Code::init_ignored, "Init ignored"},
    {Code::trigger_deadlock, "Trigger deadlock"},
    {Code::parameter, "Parameter error"},
    {Code::settings_conflict, "Settings conflict"},
    {Code::out_of_range, "Data out of range"},
    {Code::too_much_data, "Too much data"},
    {Code::illegal_value, "Illegal parameter value"},
    {Code::stale_data, "Data corrupt or stale"},
    {Code::hardware, "Hardware error"},
    {Code::hardware_missing, "Hardware missing"},
    {Code::mass_storage, "Mass storage error"},
    {Code::file_not_found, "File name not found"},
    {Code::system, "System error"},
    {Code::queue_overflow, "Queue overflow"},
    {Code::input_overrun, "Input buffer overrun"},
    {Code::query_interrupted, "Query INTERRUPTED"},
    {Code::query_unterminated, "Query UNTERMINATED"},
    {Code::query_deadlocked, "Query DEADLOCKED"},
    {Code::abort, "Abort"},
    {Code::open_channel, "Open channel"},
    {Code::drive_maximum, "Drive at its maximum"},
    {Code::gain_limit, "Gain limit"},
    {Code::displacement_limit, "Displacement limit"},
    {Code::loop_diverged, "Loop diverged"},
    {Code::xrun, "Output ran empty"},
    {Code::frames_dropped, "Frames dropped"},
    {Code::tracking_lost, "Tracking lost"},
    {Code::walker_at_edge, "Walker at the edge"},
    {Code::watchdog, "Watchdog"},
    {Code::disk, "Disk"},
    {Code::output_silent, "Abort not obeyed"},
});

constexpr std::uint8_t query_bit = 1U << 2, device_bit = 1U << 3, execution_bit = 1U << 4,
                       command_bit = 1U << 5;

}  // namespace

std::string_view standard_message(Code code) noexcept {
    const auto* found =
        std::find_if(messages.begin(), messages.end(), [&](const auto& row) { return row.first == code; });
    return found == messages.end() ? "Unknown error" : found->second;
}

bool is_command_error(Code code) noexcept { return event_bit(code) == command_bit; }
bool is_query_error(Code code) noexcept { return event_bit(code) == query_bit; }

std::uint8_t event_bit(Code code) noexcept {
    const int number = static_cast<int>(code);
    if (number == 0) return 0;
    if (number > -200 && number <= -100) return command_bit;
    if (number > -300 && number <= -200) return execution_bit;
    if (number > -500 && number <= -400) return query_bit;
    return device_bit;
}

}  // namespace shaker::scpi
