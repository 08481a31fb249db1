#pragma once
// Layout of a recording. Every group and data set is created before the first sample, because no objects can
// be added to a file that other processes read while it grows.
#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace shaker::recorded {

/// One data set of a recording.
struct Place {
    enum class Kind {
        number,   // single, 64-bit float; NaN while unknown
        text,     // single, fixed length; empty while unknown
        numbers,  // growing column, 64-bit float
        texts,    // growing column, fixed length
    };
    std::string name;
    std::string units;  // UDUNITS text; for a text: empty
    Kind kind = Kind::numbers;
    std::size_t text_bytes = 0;  // length of the longest text
    bool provisional = false;    // its rows are replaced when the recording is completed, so it is not sealed
    std::string meaning{};       // one phrase for readers of the format; not stored in the file
};

/// A group under /entry with its data sets.
struct GroupLayout {
    std::string path;
    std::string nx_class = "NXcollection";
    std::map<std::string, std::string> attributes;  // "signal", "axes", "title"
    std::vector<Place> places;
    double rows_per_s = 0;  // approximate rate of its columns; 0: few rows
    std::string meaning{};  // as of a place
};

/// A column of a table. units: UDUNITS text.
struct Column {
    std::string name;
    std::string units;
    std::vector<double> values;
};

}  // namespace shaker::recorded
