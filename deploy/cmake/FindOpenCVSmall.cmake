# The small OpenCV packages (core, imgproc) contain no OpenCVConfig.cmake. Defines the target OpenCV::small.
find_path(OPENCV_SMALL_INCLUDE_DIR opencv2/core.hpp PATH_SUFFIXES opencv4)
foreach(part core imgproc)
  find_library(OPENCV_SMALL_${part} opencv_${part})
endforeach()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenCVSmall REQUIRED_VARS OPENCV_SMALL_INCLUDE_DIR
  OPENCV_SMALL_core OPENCV_SMALL_imgproc)
if(OpenCVSmall_FOUND AND NOT TARGET OpenCV::small)
  add_library(OpenCV::small INTERFACE IMPORTED)
  set_target_properties(OpenCV::small PROPERTIES
    INTERFACE_INCLUDE_DIRECTORIES "${OPENCV_SMALL_INCLUDE_DIR}"
    INTERFACE_LINK_LIBRARIES "${OPENCV_SMALL_core};${OPENCV_SMALL_imgproc}")
endif()
