#include "hardware/comedi/comedi_board.h"

namespace faultlab::hardware {
namespace {

std::string TypeName(int type) {
  switch (type) {
    case COMEDI_SUBD_UNUSED:
      return "unused";
    case COMEDI_SUBD_AI:
      return "analog in";
    case COMEDI_SUBD_AO:
      return "analog out";
    case COMEDI_SUBD_DI:
      return "digital in";
    case COMEDI_SUBD_DO:
      return "digital out";
    case COMEDI_SUBD_DIO:
      return "digital in and out";
    case COMEDI_SUBD_COUNTER:
      return "a counter";
    default:
      return "of Comedi's type " + std::to_string(type);
  }
}

}  // namespace

ComediApi::ComediApi(const SharedLibrary& library) {
  library.Find("comedi_open", open);
  library.Find("comedi_close", close);
  library.Find("comedi_errno", error_number);
  library.Find("comedi_strerror", error_text);
  library.Find("comedi_get_n_subdevices", get_subdevices);
  library.Find("comedi_get_subdevice_type", get_type);
  library.Find("comedi_get_subdevice_flags", get_flags);
  library.Find("comedi_get_n_channels", get_channels);
  library.Find("comedi_get_maxdata", get_maxdata);
  library.Find("comedi_get_range", get_range);
  library.Find("comedi_to_phys", to_phys);
  library.Find("comedi_from_phys", from_phys);
  library.Find("comedi_data_read", data_read);
  library.Find("comedi_data_write", data_write);
  library.Find("comedi_dio_config", dio_config);
  library.Find("comedi_dio_get_config", dio_get_config);
  library.Find("comedi_dio_bitfield2", dio_bitfield2);
  library.Find("comedi_set_read_subdevice", set_read_subdevice);
  library.Find("comedi_command_test", command_test);
  library.Find("comedi_command", command);
  library.Find("comedi_cancel", cancel);
  library.Find("comedi_fileno", file_number);
  library.Find("comedi_reset", reset);
  library.Find("comedi_arm", arm);
}

ComediBoard::ComediBoard(const std::string& library, const std::string& device)
    : name_(device),
      library_(library),
      api_(library_),
      device_(api_.open(device.c_str()), api_.close) {
  if (!device_) Fail("comedi_open of " + device);
}

int ComediBoard::Require(const char* key, int subdevice, int type, int or_type) const {
  const int subdevices = api_.get_subdevices(device());
  if (subdevices < 0) Fail("comedi_get_n_subdevices");
  if (subdevice >= subdevices) {
    throw IoError(name_ + " has the subdevices 0 to " + std::to_string(subdevices - 1) +
                  ", comedi." + key + " is " + std::to_string(subdevice));
  }
  const std::string which = "subdevice " + std::to_string(subdevice) + " of " + name_;
  const int found = api_.get_type(device(), Unsigned(subdevice));
  if (found < 0) Fail("comedi_get_subdevice_type of " + which);
  if (found != type && found != or_type) {
    throw IoError(which + " is " + TypeName(found) + ", comedi." + key + " must be " +
                  TypeName(type));
  }
  const int channels = api_.get_channels(device(), Unsigned(subdevice));
  if (channels < 0) Fail("comedi_get_n_channels of " + which);
  return channels;
}

void ComediBoard::RequireChannel(const char* key, int channel, int subdevice, int channels) const {
  if (channel < channels) return;
  throw IoError("subdevice " + std::to_string(subdevice) + " of " + name_ +
                " has the channels 0 to " + std::to_string(channels - 1) + ", comedi." + key +
                " is " + std::to_string(channel));
}

void ComediBoard::Fail(const std::string& call) const {
  throw IoError(call + " failed: " + api_.error_text(api_.error_number()));
}

}  // namespace faultlab::hardware
