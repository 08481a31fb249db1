#pragma once
// Error numbers: those of SCPI-99 (volume 2, chapter 21) that this instrument uses, and its own, which are
// positive.
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>

namespace shaker::scpi {

enum class Code : std::int16_t {
    none = 0,
    invalid_character = -101,
    syntax = -102,
    invalid_separator = -103,
    data_type = -104,
    parameter_not_allowed = -108,
    missing_parameter = -109,
    mnemonic_too_long = -112,
    undefined_header = -113,
    header_suffix_out_of_range = -114,
    invalid_character_in_number = -121,
    exponent_too_large = -123,
    too_many_digits = -124,
    numeric_not_allowed = -128,
    invalid_suffix = -131,
    suffix_not_allowed = -138,
    invalid_character_data = -141,
    character_data_not_allowed = -148,
    invalid_string = -151,
    string_not_allowed = -158,
    invalid_block = -161,
    block_not_allowed = -168,
    expression = -170,
    execution = -200,
    command_protected = -203,
    trigger_ignored = -211,
    init_ignored = -213,
    trigger_deadlock = -214,
    parameter = -220,
    settings_conflict = -221,
    out_of_range = -222,
    too_much_data = -223,
    illegal_value = -224,
    stale_data = -230,
    hardware = -240,
    hardware_missing = -241,
    mass_storage = -250,
    file_not_found = -256,
    system = -310,
    queue_overflow = -350,
    input_overrun = -363,
    query_interrupted = -410,
    query_unterminated = -420,
    query_deadlocked = -430,
    abort = 101,
    open_channel = 102,
    drive_maximum = 103,
    gain_limit = 104,
    displacement_limit = 105,
    loop_diverged = 106,
    xrun = 107,
    frames_dropped = 108,
    tracking_lost = 109,
    walker_at_edge = 110,
    watchdog = 111,
    disk = 112,
    output_silent = 113,
};

/// The standard's text for a number; own numbers have texts like "Abort".
std::string_view standard_message(Code code) noexcept;

/// -1xx: the input was not understood, so the rest of the message is dropped.
bool is_command_error(Code code) noexcept;
/// -4xx: an error in the exchange of messages and answers.
bool is_query_error(Code code) noexcept;

/// The bit of the standard event status register that an error of this class sets.
std::uint8_t event_bit(Code code) noexcept;

/// Ends the execution of one message unit. `detail` names the item, its value and what is allowed.
struct Error : std::runtime_error {
    Error(Code code_, const std::string& detail) : std::runtime_error{detail}, code{code_} {}
    Code code;
};

}  // namespace shaker::scpi
