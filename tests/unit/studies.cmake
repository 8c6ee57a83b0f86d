vacuform_test(studies_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/studies_test.cpp LINKS vacuform_studies)
