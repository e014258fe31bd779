# liblcm-dev's lcm.pc requires glib-2.0, on which the package does not depend, so the files
# themselves are searched.
# Target LCM::lcm, program LCM_GEN.
find_path(LCM_INCLUDE_DIR lcm/lcm-cpp.hpp)
find_library(LCM_LIBRARY lcm)
find_program(LCM_GEN lcm-gen)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(LCM REQUIRED_VARS LCM_INCLUDE_DIR LCM_LIBRARY LCM_GEN)
if(LCM_FOUND AND NOT TARGET LCM::lcm)
  add_library(LCM::lcm UNKNOWN IMPORTED)
  set_target_properties(LCM::lcm PROPERTIES IMPORTED_LOCATION "${LCM_LIBRARY}"
    INTERFACE_SYSTEM_INCLUDE_DIRECTORIES "${LCM_INCLUDE_DIR}")
endif()
