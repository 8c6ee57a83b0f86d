vacuform_test(sample_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/sample_test.cpp LINKS vacuform_sample)
