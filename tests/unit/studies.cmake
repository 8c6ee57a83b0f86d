vacuform_test(studies_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/studies_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/calibration_test.cpp LINKS vacuform_studies)
