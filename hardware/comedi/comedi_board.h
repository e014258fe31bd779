#pragma once

#include <comedilib.h>

#include <memory>
#include <string>

#include "hardware/daq/shared_library.h"
#include "hardware/io_error.h"

namespace faultlab::hardware {

/// The functions of libcomedi that a bench needs, by the signatures of its own header.
struct ComediApi {
  explicit ComediApi(const SharedLibrary& library);

  decltype(comedi_open)* open;
  decltype(comedi_close)* close;
  decltype(comedi_errno)* error_number;
  decltype(comedi_strerror)* error_text;
  decltype(comedi_get_n_subdevices)* get_subdevices;
  decltype(comedi_get_subdevice_type)* get_type;
  decltype(comedi_get_subdevice_flags)* get_flags;
  decltype(comedi_get_n_channels)* get_channels;
  decltype(comedi_get_maxdata)* get_maxdata;
  decltype(comedi_get_range)* get_range;
  decltype(comedi_to_phys)* to_phys;
  decltype(comedi_from_phys)* from_phys;
  decltype(comedi_data_read)* data_read;
  decltype(comedi_data_write)* data_write;
  decltype(comedi_dio_config)* dio_config;
  decltype(comedi_dio_get_config)* dio_get_config;
  decltype(comedi_dio_bitfield2)* dio_bitfield2;
  decltype(comedi_set_read_subdevice)* set_read_subdevice;
  decltype(comedi_command_test)* command_test;
  decltype(comedi_command)* command;
  decltype(comedi_cancel)* cancel;
  decltype(comedi_fileno)* file_number;
  decltype(comedi_reset)* reset;
  decltype(comedi_arm)* arm;
};

/// An open board. Every call that fails throws IoError with the library's own words.
class ComediBoard {
 public:
  ComediBoard(const std::string& library, const std::string& device);

  const ComediApi& api() const { return api_; }
  comedi_t* device() const { return device_.get(); }
  const std::string& name() const { return name_; }

  /// Throws unless the board has this subdevice and it is of `type` (COMEDI_SUBD_..) or `or_type`.
  /// @param key  of the configuration: what the error tells to correct
  /// @returns its number of channels
  int Require(const char* key, int subdevice, int type, int or_type) const;
  int Require(const char* key, int subdevice, int type) const {
    return Require(key, subdevice, type, type);
  }
  /// Throws unless `subdevice`, which `Require` has accepted, has this channel.
  void RequireChannel(const char* key, int channel, int subdevice, int channels) const;

  [[noreturn]] void Fail(const std::string& call) const;

 private:
  const std::string name_;
  const SharedLibrary library_;
  const ComediApi api_;
  std::unique_ptr<comedi_t, decltype(comedi_close)*> device_;
};

inline unsigned Unsigned(int value) {
  return static_cast<unsigned>(value);
}

}  // namespace faultlab::hardware
